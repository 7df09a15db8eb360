/* talus_mpi.h: create a Talus engine from an MPI_Comm. The only public header that needs <mpi.h>. */
#ifndef TALUS_MPI_H
#define TALUS_MPI_H

#include <mpi.h>

#include "talus.h"

/** As talus_engine_create_mpi(), taking the C handle. [collective] */
static inline talus_status talus_engine_create_comm(const talus_settings *settings, MPI_Comm comm, talus_engine **out_engine) {
    return talus_engine_create_mpi(settings, (int32_t)MPI_Comm_c2f(comm), out_engine);
}

#endif /* TALUS_MPI_H */
