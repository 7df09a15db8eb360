# talus_sources(OUT [EXCLUDE regex]): all *.cpp below the calling folder, so that adding a file needs no edit here.
#
# Files named *_avx512.cpp are compiled for AVX-512 on top of the baseline: they may only be entered after asking the
# processor, and must keep their templates and inline functions to themselves (an inline function compiled with these
# flags could otherwise be the copy that the linker keeps for everyone). GCC 12 takes the undefined operands of its own
# intrinsics for mistakes of ours, hence the warning that is off.
function(talus_sources out)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "EXCLUDE" "")
    file(GLOB_RECURSE found CONFIGURE_DEPENDS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" *.cpp)
    if(arg_EXCLUDE)
        list(FILTER found EXCLUDE REGEX "${arg_EXCLUDE}")
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12)
        # Structures are copied as they are loaded, whole (a load cannot take what stands in two stores that are under way).
        set(for_gcc "-mmove-max=512;-mstore-max=512;-Wno-maybe-uninitialized")
    endif()
    foreach(file IN LISTS found)
        if(file MATCHES "_avx512\\.cpp$")
            set_source_files_properties("${file}" PROPERTIES COMPILE_OPTIONS "-mavx512f;-mavx512dq;-mavx512vl;${for_gcc}")
        endif()
    endforeach()
    set(${out} ${found} PARENT_SCOPE)
endfunction()

# talus_static_library(NAME ...sources): a static, position-independent part of Talus that sees the repository's root.
function(talus_static_library name)
    set(sources ${ARGN})
    if(NOT sources) # headers only: an archive still needs one object
        set(sources "${CMAKE_CURRENT_BINARY_DIR}/${name}_empty.cpp")
        file(CONFIGURE OUTPUT "${sources}" CONTENT "")
    endif()
    add_library(${name} STATIC ${sources})
    target_include_directories(${name} PUBLIC "${PROJECT_SOURCE_DIR}")
    target_link_libraries(${name} PRIVATE talus_flags)
endfunction()
