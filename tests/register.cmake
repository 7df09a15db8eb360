# How a file below tests/ becomes an executable and one or more CTest entries (the rules are in CMakeLists.txt).

set(TALUS_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with numpy, h5py and matplotlib, for tests of the tools")
set(TALUS_TEST_LAUNCHER "" CACHE STRING "Command put before every test program, e.g. setarch;-R for ThreadSanitizer")

set(sanitizer_files "${PROJECT_SOURCE_DIR}/tools/sanitizers")
set(talus_test_environment
    "TALUS_BUILD_DIR=${PROJECT_BINARY_DIR}"
    "TALUS_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    "TALUS_SANITIZE=${TALUS_SANITIZE}"
    # Tests run as root in containers, with more ranks than cores, and where the kernel forbids reading another
    # process's memory (the single-copy path, which then complains on every message).
    OMPI_ALLOW_RUN_AS_ROOT=1
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    OMPI_MCA_rmaps_base_oversubscribe=1
    OMPI_MCA_mpi_yield_when_idle=1
    OMPI_MCA_btl_vader_single_copy_mechanism=none
    "ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1:fast_unwind_on_malloc=0"
    "LSAN_OPTIONS=suppressions=${sanitizer_files}/lsan.supp:print_suppressions=0"
    "TSAN_OPTIONS=suppressions=${sanitizer_files}/tsan.supp:second_deadlock_stack=1:ignore_noninstrumented_modules=1"
    "UBSAN_OPTIONS=print_stacktrace=1")

# The value of a `key: value` comment in the first lines of a file; empty if there is none.
function(talus_test_key file key out)
    file(STRINGS "${file}" lines LIMIT_COUNT 5)
    set(${out} "" PARENT_SCOPE)
    foreach(line IN LISTS lines)
        if(line MATCHES "^[ \t]*(//|#|/\\*)[ \t]*${key}:[ \t]*([A-Za-z0-9 ]*[A-Za-z0-9])")
            set(${out} "${CMAKE_MATCH_2}" PARENT_SCOPE)
            return()
        endif()
    endforeach()
endfunction()

# add_test with the properties every test has. Uses file, kind and the keys of the calling scope.
function(talus_add_test name processors)
    add_test(NAME ${name} COMMAND ${ARGN})
    set(labels ${kind})
    set(limit 120)
    if(key_label)
        list(APPEND labels ${key_label})
        if("slow" IN_LIST labels)
            set(limit 1800)
        endif()
    endif()
    if(key_timeout)
        set(limit ${key_timeout})
    endif()
    if(TALUS_SANITIZE)
        math(EXPR limit "${limit} * 5")
    endif()
    set_tests_properties(${name} PROPERTIES
        LABELS "${labels}" TIMEOUT ${limit} PROCESSORS ${processors} SKIP_RETURN_CODE 77
        ENVIRONMENT "${talus_test_environment}")
endfunction()

function(talus_register_test file)
    get_filename_component(kind "${file}" DIRECTORY)
    string(REPLACE "/" "." kind "${kind}")
    get_filename_component(subject "${file}" NAME_WE)
    string(REGEX REPLACE "^test_" "" subject "${subject}")
    get_filename_component(extension "${file}" LAST_EXT)
    set(path "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
    set(name talus.${kind}.${subject})

    # The keys are read at configure time: editing a test's head must be noticed.
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${path}")
    foreach(key label timeout processors ranks)
        talus_test_key("${path}" ${key} key_${key})
    endforeach()
    string(REPLACE " " ";" key_label "${key_label}")
    if(NOT key_processors)
        set(key_processors 1)
    endif()

    if(kind STREQUAL "bench" AND NOT TARGET talus_bench_parts)
        return()
    endif()
    if(extension STREQUAL ".sh")
        talus_add_test(${name} ${key_processors} bash "${path}")
        return()
    elseif(kind STREQUAL "python")
        talus_add_test(${name} ${key_processors} "${TALUS_PYTHON}" -B -m pytest -q -p no:cacheprovider "${path}")
        return()
    elseif(extension STREQUAL ".py")
        talus_add_test(${name} ${key_processors} "${TALUS_PYTHON}" "${path}")
        return()
    endif()
    if(kind MATCHES "^(physics|capi)$" AND NOT TARGET talus)
        message(STATUS "${file}: left out, the C ABI has no sources yet")
        return()
    endif()

    string(REPLACE "." "_" target "test_${kind}_${subject}")
    add_executable(${target} "${file}")
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
    target_link_libraries(${target} PRIVATE talus_flags)
    if(extension STREQUAL ".c")
        # Proof that the header is C99, and clean: on these files a warning is always an error.
        set_target_properties(${target} PROPERTIES C_STANDARD 99)
        target_compile_options(${target} PRIVATE -pedantic -Werror)
        target_link_libraries(${target} PRIVATE talus m)
    elseif(kind MATCHES "^(physics|capi)$")
        target_link_libraries(${target} PRIVATE talus_test_support talus GTest::gtest_main)
    elseif(kind STREQUAL "parallel")
        target_sources(${target} PRIVATE ${main_sources})
        target_link_libraries(${target} PRIVATE talus_test_support talus_capi)
    else()
        target_link_libraries(${target} PRIVATE talus_test_support talus_capi GTest::gtest_main)
    endif()
    if(kind STREQUAL "bench")
        target_link_libraries(${target} PRIVATE talus_bench_parts)
    endif()

    if(NOT kind STREQUAL "parallel")
        talus_add_test(${name} ${key_processors} ${TALUS_TEST_LAUNCHER} $<TARGET_FILE:${target}>)
        return()
    endif()
    if(NOT key_ranks)
        message(FATAL_ERROR "tests/${file}: say on how many ranks it runs, e.g. \"// ranks: 1 2 3 4\" in its first lines")
    endif()
    string(REPLACE " " ";" key_ranks "${key_ranks}")
    foreach(ranks IN LISTS key_ranks)
        set(busy ${ranks})
        if(busy GREATER 2)
            set(busy 2) # ranks yield to each other; more would only keep ctest -j2 from running anything beside
        endif()
        talus_add_test(${name}.np${ranks} ${busy}
            mpirun -n ${ranks} --oversubscribe --bind-to none --mca mpi_yield_when_idle 1
            ${TALUS_TEST_LAUNCHER} $<TARGET_FILE:${target}>)
    endforeach()
endfunction()
