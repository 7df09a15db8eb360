/* coupling.c: Talus inside a host that advances something of its own. A rigid block on a spring holds back a heap of grains; it is
 * a wall of Talus: its force comes out, its velocity goes in. The host's steps are implicit: the velocity at a step's end has to
 * fit the force at that end. So the host tries a velocity, sees what force it meets, takes the engine back to where the step
 * began, and tries what that force asks for, until both agree.
 *
 *   cc -std=c99 coupling.c $(pkg-config --cflags --libs talus) -lm -o coupling && ./coupling [HOST STEPS]
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <talus.h>

/* [s] of the host, in which Talus takes ten steps; [kg], [N/m], [N s/m] of the block. */
static const double kStep = 4e-4, kMass = 0.05, kSpring = 60, kDashpot = 1;

/* The one way out of a failure. Talus itself never exits; a program of one page may. */
static void check(talus_status status, const talus_engine *engine, const char *doing) {
    if (status >= 0) return;
    fprintf(stderr, "coupling: %s: %s: %s\n", doing, talus_status_string(status), engine ? talus_engine_message(engine) : talus_message());
    exit(1);
}

/* The state that a host step begins with. */
static talus_kept *begin(talus_engine *engine) {
    talus_kept *kept = NULL;
    check(talus_engine_keep(engine, &kept), engine, "keeping the state");
    return kept;
}

static talus_engine *make(talus_settings *settings) {
    talus_engine *engine = NULL;
    talus_material sand;
    talus_contact contact;
    talus_wall wall;
    talus_fill fill;
    int32_t id, k;
    int64_t placed;
    /* Every struct starts from its defaults; these calls fail for NULL only. */
    talus_settings_init(settings), talus_material_init(&sand), talus_contact_init(&contact), talus_wall_init(&wall), talus_fill_init(&fill);
    for (k = 0; k < 3; ++k) {
        settings->domain_lo[k] = fill.lo[k] = 0;
        settings->domain_hi[k] = k == 2 ? 0.03 : 0.12; /* along x there is room for the block to give way */
        fill.hi[k] = k == 0 ? 0.06 : k == 1 ? 0.08 : 0.03;
    }
    fill.radius_min = 0.0016, fill.radius_max = 0.002;
    settings->periodic[2] = 1, settings->time_step = kStep / 10;
    check(talus_engine_create(settings, &engine), NULL, "creating the engine");
    sand.young = 1e7, sand.poisson = 0.25, sand.density = 2600;
    check(talus_material_add(engine, &sand, &id), engine, "adding the material");
    contact.restitution = 0.4, contact.friction = 0.5, contact.rolling_friction = 0.1;
    check(talus_contact_set(engine, id, id, &contact), engine, "setting contacts");
    for (k = 0; k < 3; ++k) { /* 0: behind the heap, 1: the floor, 2: the block */
        wall.point[0] = k == 2 ? 0.06 : 0;
        wall.normal[0] = k == 1 ? 0 : 1 - k, wall.normal[1] = k == 1;
        check(talus_wall_add(engine, &wall, &id), engine, "adding a wall");
    }
    check(talus_particles_fill(engine, &fill, &placed), engine, "filling");
    check(talus_engine_step(engine, 5000, NULL), engine, "settling"); /* with the block held */
    return engine;
}

/* The force of the grains on the block at the end of a host step in which it moves at this velocity. */
static double push(talus_engine *engine, double speed) {
    const double velocity[3] = {speed, 0, 0};
    talus_wall_state block;
    talus_wall_state_init(&block);
    check(talus_wall_set_velocity(engine, 2, velocity), engine, "moving the block");
    check(talus_engine_step(engine, 10, NULL), engine, "stepping");
    check(talus_wall_get(engine, 2, &block), engine, "reading the block");
    return block.force[0];
}

int main(int argc, char **argv) {
    const long steps = argc > 1 ? strtol(argv[1], NULL, 10) : 200;
    double x = 0, v = 0, fits, tried, force = 0; /* of the block, from where the spring is at rest */
    long k, tries = steps; /* one a step, and one for each time it was taken back */
    talus_settings settings;
    talus_state state;
    talus_engine *engine = make(&settings);
    for (k = 0; k < steps; ++k) {
        talus_kept *kept = begin(engine);
        for (fits = v;; check(talus_engine_restore(engine, kept), engine, "going back"), ++tries) {
            force = push(engine, tried = fits);
            fits = (kMass * v + kStep * (force - kSpring * x)) / (kMass + kStep * kDashpot + kStep * kStep * kSpring); /* Euler, implicit */
            if (fabs(fits - tried) < 1e-7) break; /* [m/s] */
            if (tries > 50 * steps) return fprintf(stderr, "coupling: host step %ld does not converge\n", k), 1;
        }
        talus_kept_destroy(kept);
        v = tried, x += kStep * v; /* the wall moved at this velocity, so the block did */
    }
    talus_state_init(&state);
    check(talus_engine_state(engine, &state), engine, "observing");
    printf("%ld host steps in %ld tries; the block gave way by %.3f mm, pushed by %.3f N\n", steps, tries, 1e3 * x, force);
    printf("digest %016" PRIx64 "%016" PRIx64 "\n", state.digest_hi, state.digest_lo);
    return talus_engine_destroy(engine), 0;
}
