/* heap.c: the smallest whole host of Talus. A column of grains collapses on a rough floor; we print the angle of repose of the
 * heap it leaves, and the digest, which is the same for any number of threads (and, in heap_mpi.c, of ranks).
 *
 *   cc -std=c99 heap.c $(pkg-config --cflags --libs talus) -lm -o heap && ./heap [GRAINS [THREADS]]
 */
#include <inttypes.h>
#include <stdio.h>

#include "heap_angle.h"
#include "heap_scene.h"

/* What Talus calls a failure is negative, and its text is had from the engine, or where none was made from the thread.
 * TALUS_STOPPED is positive: the host asked for it by talus_engine_request_stop(), and we never do. */
static int failed(talus_status status, const talus_engine *engine, const char *doing) {
    if (status >= 0) return 0;
    fprintf(stderr, "heap: %s: %s: %s\n", doing, talus_status_string(status), engine ? talus_engine_message(engine) : talus_message());
    return 1;
}

static int run(talus_engine *engine, const talus_settings *settings, int64_t grains) {
    talus_state state;
    int64_t placed = 0;
    double angle = 0, at_most = 0;

    if (failed(heap_build(engine, settings, grains, &placed), engine, "building the scene")) return 1;
    if (placed < grains) {
        fprintf(stderr, "heap: only %" PRId64 " of %" PRId64 " grains found a place\n", placed, grains);
        return 1;
    }
    if (failed(talus_engine_critical_step(engine, &at_most), engine, "asking for the Rayleigh step")) return 1;
    printf("%" PRId64 " grains fall; the time step is %.2f of Rayleigh's\n", placed, settings->time_step / at_most);

    /* Observing costs about a force evaluation, hence not every step. The heap rests when grains hold each other. */
    talus_state_init(&state);
    do {
        if (failed(talus_engine_step(engine, 500, NULL), engine, "stepping")) return 1;
        if (failed(talus_engine_state(engine, &state), engine, "observing")) return 1;
    } while (state.time < 3 && (state.time < 0.3 || state.max_speed > 0.02));

    if (failed(heap_angle(engine, settings, &angle), engine, "measuring the heap")) return 1;
    printf("at rest after %" PRId64 " steps (%.2f s); largest overlap %.1f %%\n", state.step, state.time, 100 * state.max_overlap);
    printf("angle of repose %.1f degrees\n", angle);
    printf("digest %016" PRIx64 "%016" PRIx64 "\n", state.digest_hi, state.digest_lo);
    return 0;
}

int main(int argc, char **argv) {
    const int64_t grains = argc > 1 ? strtoll(argv[1], NULL, 10) : 2000;
    const int32_t threads = argc > 2 ? (int32_t)strtol(argv[2], NULL, 10) : 1;
    talus_settings settings;
    talus_engine *engine = NULL;
    int exit_code;

    if (grains < 50 || threads < 1) {
        fprintf(stderr, "usage: heap [GRAINS [THREADS]], at least 50 grains and one thread\n");
        return 2;
    }
    heap_settings(&settings, grains, threads);
    if (failed(talus_engine_create(&settings, &engine), NULL, "creating the engine")) return 1;
    exit_code = run(engine, &settings, grains);
    talus_engine_destroy(engine);
    return exit_code;
}
