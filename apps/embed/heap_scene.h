/* heap_scene.h: a column of grains that collapses on a rough floor; shared by heap.c and heap_mpi.c, since the physics does
 * not depend on ranks. Every function hands a failure of Talus to its caller, who knows how the program may end. */
#ifndef HEAP_SCENE_H
#define HEAP_SCENE_H

#include <math.h>
#include <talus.h>

#define TRY(call) do { const talus_status status_ = (call); if (status_ < 0) return status_; } while (0)

static const double kRadius = 0.003; /* [m] the largest; the smallest is four fifths of it */
static const int64_t kFreeLabel = INT64_C(1) << 40; /* labels are for ever: grains of the floor have those below */

/* The box is as wide as the heap may become, and periodic along z: four grains thick, so that most work shows in x and y. */
static void heap_settings(talus_settings *settings, int64_t grains, int32_t threads) {
    const double side = 2.2 * kRadius * sqrt((double)grains / 4.0);
    talus_settings_init(settings); /* fails for NULL only */
    settings->domain_lo[0] = -2.5 * side;
    settings->domain_hi[0] = 2.5 * side;
    settings->domain_lo[1] = settings->domain_lo[2] = 0;
    settings->domain_hi[1] = 1.6 * side + 10 * kRadius;
    settings->domain_hi[2] = 9 * kRadius;
    settings->periodic[2] = 1;
    settings->threads = threads;
    settings->time_step = 4e-5;
}

/* Everything that has to be there before the first step. Materials and walls get their ids in the order they are added. */
static talus_status heap_build(talus_engine *engine, const talus_settings *settings, int64_t grains, int64_t *out_placed) {
    const double ends[2][2] = {{settings->domain_lo[0], 1}, {settings->domain_hi[0], -1}}; /* place, normal into the box */
    talus_material sand;
    talus_contact contact;
    talus_wall wall;
    talus_fill fill;
    int32_t id; /* of the material and walls added: 0, 1, 2 ... */
    int k;

    TRY(talus_material_init(&sand));
    sand.young = 1e7; /* softer than quartz by far: stiffness costs steps, and at this weight overlaps stay small */
    sand.poisson = 0.25;
    sand.density = 2600;
    TRY(talus_material_add(engine, &sand, &id));
    TRY(talus_contact_init(&contact));
    contact.restitution = 0.4;
    contact.friction = 0.7;
    contact.rolling_friction = 0.2;
    TRY(talus_contact_set(engine, 0, 0, &contact)); /* walls are of sand, too */

    TRY(talus_wall_init(&wall));
    wall.normal[1] = 1;
    TRY(talus_wall_add(engine, &wall, &id));
    for (k = 0; k < 2; ++k) {
        wall.point[0] = ends[k][0];
        wall.normal[0] = ends[k][1];
        wall.normal[1] = 0;
        TRY(talus_wall_add(engine, &wall, &id));
    }

    /* Rough: one layer of grains on the floor, which are held. */
    TRY(talus_fill_init(&fill));
    for (k = 0; k < 3; ++k) {
        fill.lo[k] = settings->domain_lo[k];
        fill.hi[k] = settings->domain_hi[k];
    }
    fill.hi[1] = 2.2 * kRadius;
    fill.radius_min = 0.8 * kRadius;
    fill.radius_max = kRadius;
    fill.group = 1;
    TRY(talus_particles_fill(engine, &fill, out_placed));
    TRY(talus_group_set(engine, 1, TALUS_GROUP_FROZEN, NULL, NULL));

    fill.lo[0] = settings->domain_lo[0] / 5; /* the column, a fifth of the box wide */
    fill.hi[0] = settings->domain_hi[0] / 5;
    fill.lo[1] = fill.hi[1];
    fill.hi[1] = settings->domain_hi[1];
    fill.group = 0;
    fill.first_label = kFreeLabel;
    fill.count = grains;
    return talus_particles_fill(engine, &fill, out_placed); /* fewer than asked for is no failure: the caller looks */
}
#endif
