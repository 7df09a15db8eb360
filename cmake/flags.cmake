# Compiler flags shared by every target of Talus, as the interface library talus_flags.
#
# The promise of equal bits rests on the first group: one baseline instruction set, no contraction of a*b+c behind
# our back, and no -ffast-math. errno and floating-point traps are not used, so giving them up changes no result and
# lets square roots and comparisons vectorise.

add_library(talus_flags INTERFACE)
target_compile_options(talus_flags INTERFACE
    -march=x86-64-v3 -ffp-contract=off -fno-math-errno -fno-trapping-math
    -Wall -Wextra)
# GCC otherwise copies structures of vectors sixteen bytes at a time through the stack, at a tenth of the force kernel's time.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12)
    target_compile_options(talus_flags INTERFACE -mmove-max=256 -mstore-max=256)
endif()
# A vector of words is no vector of doubles. (Clang's intrinsics and comparisons make vectors of long long, which would be strangers too.)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(talus_flags INTERFACE -fno-lax-vector-conversions)
endif()
if(TALUS_WERROR)
    target_compile_options(talus_flags INTERFACE -Werror)
endif()
if(TALUS_ASSERTIONS)
    target_compile_definitions(talus_flags INTERFACE TALUS_ASSERTIONS=1)
endif()

# h5pcc names every library HDF5 was ever linked with; only those called from here become dependencies.
target_link_options(talus_flags INTERFACE -Wl,--as-needed)

if(TALUS_SANITIZE)
    target_compile_options(talus_flags INTERFACE
        -fsanitize=${TALUS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(talus_flags INTERFACE -fsanitize=${TALUS_SANITIZE})
endif()
