# Every library Talus uses, each found once here and given a target. `tools/setup` installs them on Debian.

list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}")
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)

# core
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_path(TALUS_RANDOM123_INCLUDE Random123/philox.h REQUIRED)
find_path(TALUS_XXHASH_INCLUDE xxhash.h REQUIRED)
add_library(talus_header_libraries INTERFACE)
target_include_directories(talus_header_libraries SYSTEM INTERFACE
    "${TALUS_RANDOM123_INCLUDE}" "${TALUS_XXHASH_INCLUDE}")
target_compile_definitions(talus_header_libraries INTERFACE XXH_INLINE_ALL)
target_link_libraries(talus_header_libraries INTERFACE Eigen3::Eigen fmt::fmt)

# runtime. The C interface of MPI is all we use: through MPI_C the deprecated C++ bindings are not even linked.
find_package(TBB REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)
add_library(talus_mpi INTERFACE)
target_link_libraries(talus_mpi INTERFACE MPI::MPI_C)
target_compile_definitions(talus_mpi INTERFACE OMPI_SKIP_MPICXX MPICH_SKIP_MPICXX)

# Debian installs several flavours of HDF5 side by side and lets an alternative name one of them h5pcc; with both
# MPIs installed that may be the other one, so the flavour of Open MPI is asked for by name first.
if(NOT HDF5_C_COMPILER_EXECUTABLE)
    find_program(HDF5_C_COMPILER_EXECUTABLE NAMES h5pcc.openmpi h5pcc)
endif()
set(HDF5_PREFER_PARALLEL TRUE)
find_package(HDF5 REQUIRED COMPONENTS C)
if(NOT HDF5_IS_PARALLEL)
    message(FATAL_ERROR
        "The HDF5 found (${HDF5_C_INCLUDE_DIRS}) is built without MPI. Talus writes one file from many ranks and "
        "needs the parallel library: install libhdf5-openmpi-dev, or point HDF5_C_COMPILER_EXECUTABLE to its h5pcc.")
endif()
add_library(talus_hdf5 INTERFACE)
target_include_directories(talus_hdf5 SYSTEM INTERFACE ${HDF5_C_INCLUDE_DIRS})
target_link_libraries(talus_hdf5 INTERFACE ${HDF5_C_LIBRARIES} talus_mpi)

# apps
if(TALUS_BUILD_APPS OR TALUS_BUILD_TESTS)
    # The header-only mode: Debian's CMake package of toml++ would make its shared library a dependency at run time.
    find_path(TALUS_TOMLPLUSPLUS_INCLUDE toml++/toml.h REQUIRED)
    add_library(talus_toml INTERFACE)
    target_include_directories(talus_toml SYSTEM INTERFACE "${TALUS_TOMLPLUSPLUS_INCLUDE}")
    find_package(CLI11 REQUIRED)
    find_package(nlohmann_json REQUIRED)
endif()
if(TALUS_BUILD_BENCH)
    find_package(benchmark REQUIRED)
endif()

# tests
if(TALUS_BUILD_TESTS)
    find_package(GTest REQUIRED)
endif()
