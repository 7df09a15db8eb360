// runtime/comm/mpi_handle.hpp: what the sources that talk MPI share.
#pragma once

#include <mpi.h>

#include "core/error.hpp"
#include "runtime/comm/communicator.hpp"

namespace talus::runtime {

struct Communicator::Handle {
    MPI_Comm comm = MPI_COMM_NULL;
    MPI_Request reduction = MPI_REQUEST_NULL;
};

inline void check_mpi(int code, const char* call) {
    if (code == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(code, text, &length);
    core::fail(core::ErrorKind::comm, "{} failed: {}", call, std::string(text, static_cast<std::size_t>(length)));
}

/// Tags on the engine's own communicator.
enum Tag : int { kHaloTag = 1, kExchangeTag = 2 }; // exchanges alternate between kExchangeTag and the next

} // namespace talus::runtime
