/* old_header.c: a program as it was compiled against the first talus.h (headers/talus-0.1.0.h). talus_settings and talus_state
 * have grown since; the library must read and write no more of them than was there. Built by test_old_header.sh. */
#include "headers/talus-0.1.0.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GUARD 256 /* bytes behind each struct, more than any struct may ever grow by unnoticed */

static int failures = 0;

static void check(int good, const char *what) {
    if (!good) {
        fprintf(stderr, "failed: %s\n", what);
        ++failures;
    }
}
#define CHECK(condition) check((condition) != 0, #condition)

/* A struct with guard bytes behind it: room for `size` bytes that are the library's and GUARD that are not. */
static void *guarded(size_t size) {
    unsigned char *memory = malloc(size + GUARD);
    if (memory == NULL) exit(1);
    memset(memory, 0xa5, size + GUARD);
    return memory;
}
static void check_guard(const void *memory, size_t size, const char *after) {
    const unsigned char *bytes = (const unsigned char *)memory + size;
    int k, written = 0;
    for (k = 0; k < GUARD; ++k) written += bytes[k] != 0xa5;
    if (written > 0) fprintf(stderr, "failed: %s wrote %d bytes behind a struct of %d\n", after, written, (int)size);
    failures += written > 0;
}
/* Every _init there was. It knows no size but the one that was compiled here. */
#define TRY_INIT(type)                                                     \
    do {                                                                   \
        type *fresh = guarded(sizeof(type));                               \
        CHECK(type##_init(fresh) == TALUS_OK);                             \
        CHECK(fresh->struct_size == sizeof(type));                         \
        check_guard(fresh, sizeof(type), #type "_init");                   \
        free(fresh);                                                       \
    } while (0)

static void ok(talus_status status, const talus_engine *engine, const char *doing) {
    if (status == TALUS_OK) return;
    fprintf(stderr, "failed: %s: %s\n", doing, engine != NULL ? talus_engine_message(engine) : talus_message());
    exit(1);
}

int main(void) {
    static const int64_t labels[2] = {3, 4};
    static const double positions[6] = {0.5, 0.05, 0.5, 0.52, 0.2, 0.5}, radii[2] = {0.05, 0.05}, lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
    talus_settings *settings = guarded(sizeof *settings);
    talus_state *state = guarded(sizeof *state);
    talus_wall_state *wall_state = guarded(sizeof *wall_state);
    talus_energy *energy = guarded(sizeof *energy);
    talus_view *view = guarded(sizeof *view);
    talus_particles particles;
    talus_material material;
    talus_contact contact;
    talus_wall wall;
    talus_engine *engine = NULL;
    int32_t id = -1;

    CHECK(talus_version() >= TALUS_VERSION_NUMBER);
    TRY_INIT(talus_laws);
    TRY_INIT(talus_settings);
    TRY_INIT(talus_material);
    TRY_INIT(talus_contact);
    TRY_INIT(talus_wall);
    TRY_INIT(talus_fill);
    TRY_INIT(talus_state);
    TRY_INIT(talus_energy);

    ok(talus_settings_init(settings), NULL, "settings");
    memcpy(settings->domain_lo, lo, sizeof lo);
    memcpy(settings->domain_hi, hi, sizeof hi);
    settings->time_step = 1e-5;
    /* What lies behind the old struct is not the caller's to answer for: garbage there must not become a setting. */
    settings->struct_size = sizeof *settings;
    memset((unsigned char *)settings + sizeof *settings, 0xa5, GUARD);
    ok(talus_engine_create(settings, &engine), NULL, "creating the engine");

    ok(talus_material_init(&material), NULL, "material");
    material.young = 1e7, material.poisson = 0.2, material.density = 2500;
    ok(talus_material_add(engine, &material, &id), engine, "material");
    ok(talus_contact_init(&contact), NULL, "contact");
    contact.restitution = 0.5, contact.friction = 0.5;
    ok(talus_contact_set(engine, id, id, &contact), engine, "contact");
    ok(talus_wall_init(&wall), NULL, "wall");
    wall.normal[1] = 1;
    ok(talus_wall_add(engine, &wall, &id), engine, "wall");
    memset(&particles, 0, sizeof particles);
    particles.struct_size = sizeof particles;
    particles.count = 2, particles.label = labels, particles.position = positions, particles.radius = radii;
    ok(talus_particles_insert(engine, &particles, 0.05), engine, "inserting");
    ok(talus_engine_step(engine, 100, NULL), engine, "stepping");

    /* As a program of that time set struct_size, by _init or, where there was none, by hand. */
    memset(state, 0xa5, sizeof *state + GUARD);
    state->struct_size = sizeof *state;
    ok(talus_engine_state(engine, state), engine, "state");
    check_guard(state, sizeof *state, "talus_engine_state");
    CHECK(state->struct_size == sizeof *state);
    CHECK(state->step == 100 && state->particles == 2 && state->ranks == 1);
    CHECK(state->max_speed > 0.0 && state->wall_contacts == 1);
    CHECK(state->digest_lo != UINT64_C(0xa5a5a5a5a5a5a5a5) && state->digest_hi != UINT64_C(0xa5a5a5a5a5a5a5a5));

    wall_state->struct_size = sizeof *wall_state;
    ok(talus_wall_get(engine, id, wall_state), engine, "wall");
    check_guard(wall_state, sizeof *wall_state, "talus_wall_get");
    CHECK(wall_state->contacts == 1 && wall_state->force[1] < 0.0);

    energy->struct_size = sizeof *energy;
    ok(talus_engine_energy(engine, energy), engine, "energy");
    check_guard(energy, sizeof *energy, "talus_engine_energy");
    CHECK(energy->kinetic > 0.0);

    view->struct_size = sizeof *view;
    ok(talus_particles_view(engine, TALUS_FIELD_POSITION, view), engine, "view");
    check_guard(view, sizeof *view, "talus_particles_view");
    CHECK(view->count == 2 && view->components == 3);

    talus_engine_destroy(engine);
    free(view), free(energy), free(wall_state), free(state), free(settings);
    return failures != 0;
}
