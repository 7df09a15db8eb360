/* heap_angle.h: the angle of repose of the heap of heap_scene.h, from positions gathered to one rank. */
#ifndef HEAP_ANGLE_H
#define HEAP_ANGLE_H

#include <stdlib.h>

#include "heap_scene.h"

/* The angle of repose [degree], on rank 0 (0 on the others): the slope of a line through the surface of both flanks. */
static talus_status heap_angle(talus_engine *engine, const talus_settings *settings, double *out_angle) {
    const double width = 2 * kRadius, left = settings->domain_lo[0];
    const int bins = (int)((settings->domain_hi[0] - left) / width) + 1;
    double top = 0, n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, *position = NULL, *surface = NULL;
    talus_status status;
    talus_state state;
    int64_t count = 0, g;
    int b;

    *out_angle = 0;
    TRY(talus_state_init(&state));
    TRY(talus_engine_state(engine, &state));
    position = malloc((size_t)state.particles * 3 * sizeof *position); /* rank 0 fills it; no rank knows that here */
    surface = calloc((size_t)bins, sizeof *surface);
    /* Gathering is collective: without memory we do not stay away but have room for none, which is the same failure everywhere. */
    status = talus_particles_gather(engine, TALUS_FIELD_POSITION, position && surface ? state.particles : 0, position, &count);
    if (status < 0) count = 0;
    for (g = 0; g < count; ++g) {
        const double x = position[3 * g], y = position[3 * g + 1];
        b = (int)((x - left) / width);
        if (y > surface[b]) surface[b] = y;
        if (y > top) top = y;
    }
    for (b = 0; b < bins && count > 0; ++b) {
        const double x = fabs(left + (b + 0.5) * width), y = surface[b];
        if (y < 0.25 * top || y > 0.85 * top) continue; /* neither the round top nor the toe of single grains */
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    if (n > 2) *out_angle = atan(-(n * sxy - sx * sy) / (n * sxx - sx * sx)) * 57.29577951308232;
    free(surface);
    free(position);
    return status;
}
#endif
