/* heap_mpi.c: heap.c on the ranks of a communicator. What differs is who may speak, how the engine is made, and how the program
 * may end; the physics is the same file, and so is the digest, on any number of ranks.
 *
 *   mpicc -std=c99 heap_mpi.c $(pkg-config --cflags --libs talus) -lm -o heap_mpi
 *   mpirun -n 3 --bind-to none ./heap_mpi [GRAINS [THREADS OF EACH RANK]]
 */
#include <inttypes.h>
#include <stdio.h>
#include <talus_mpi.h>

#include "heap_angle.h"
#include "heap_scene.h"

static int is_root = 0; /* one rank prints */

/* A failure of a collective call is the same status and text on every rank, so one rank tells it and all leave by the front
 * door. Only when MPI itself failed nothing can be agreed on: then the host, never the library, ends the job. */
static int failed(talus_status status, const talus_engine *engine, const char *doing) {
    if (status >= 0) return 0;
    if (is_root || status == TALUS_ERR_COMM)
        fprintf(stderr, "heap_mpi: %s: %s: %s\n", doing, talus_status_string(status),
                engine ? talus_engine_message(engine) : talus_message());
    if (status == TALUS_ERR_COMM) MPI_Abort(MPI_COMM_WORLD, 1);
    return 1;
}

static int run(talus_engine *engine, const talus_settings *settings, int64_t grains) {
    talus_state state;
    int64_t placed = 0;
    double angle = 0;

    if (failed(heap_build(engine, settings, grains, &placed), engine, "building the scene")) return 1;
    if (placed < grains) {
        if (is_root) fprintf(stderr, "heap_mpi: only %" PRId64 " of %" PRId64 " grains found a place\n", placed, grains);
        return 1;
    }
    /* The state is agreed over ranks: every rank sees the same numbers, and all leave the loop together. */
    talus_state_init(&state);
    do {
        if (failed(talus_engine_step(engine, 500, NULL), engine, "stepping")) return 1;
        if (failed(talus_engine_state(engine, &state), engine, "observing")) return 1;
    } while (state.time < 3 && (state.time < 0.3 || state.max_speed > 0.02));

    if (failed(heap_angle(engine, settings, &angle), engine, "measuring the heap")) return 1;
    if (!is_root) return 0;
    printf("at rest after %" PRId64 " steps (%.2f s) on %d ranks\n", state.step, state.time, (int)state.ranks);
    printf("%" PRId64 " grains changed ranks, %" PRId64 " times the cuts moved\n", state.migrations, state.rebalances);
    printf("angle of repose %.1f degrees\n", angle);
    printf("digest %016" PRIx64 "%016" PRIx64 "\n", state.digest_hi, state.digest_lo);
    return 0;
}

int main(int argc, char **argv) {
    int64_t grains = 0;
    int32_t threads = 0;
    int level = MPI_THREAD_SINGLE, rank = 0, exit_code = 1;
    talus_settings settings;
    talus_engine *engine = NULL;

    /* The host owns MPI. The engine's graph calls it from one thread at a time, which need not be this one. */
    if (MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS) return 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    is_root = rank == 0;
    grains = argc > 1 ? strtoll(argv[1], NULL, 10) : 2000;
    threads = argc > 2 ? (int32_t)strtol(argv[2], NULL, 10) : 1;
    if (grains < 50 || threads < 1) {
        if (is_root) fprintf(stderr, "usage: heap_mpi [GRAINS [THREADS]], at least 50 grains and one thread\n");
        MPI_Finalize();
        return 2;
    }
    heap_settings(&settings, grains, threads);
    /* Talus works on a duplicate of the communicator; errors on ours stay as we left them. */
    if (!failed(talus_engine_create_comm(&settings, MPI_COMM_WORLD, &engine), NULL, "creating the engine"))
        exit_code = run(engine, &settings, grains);
    talus_engine_destroy(engine); /* before MPI_Finalize; NULL is fine */
    MPI_Finalize();
    return exit_code;
}
