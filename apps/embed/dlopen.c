/* dlopen.c: a host that is built without Talus. It opens the library at run time, as a plug-in would, looks up what it calls,
 * and lets one grain fall: the engine's trajectory is that of the textbook.
 *
 *   cc -std=c99 dlopen.c $(pkg-config --cflags talus) -ldl -lm -o dlopen && ./dlopen [libtalus.so.0]
 */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <talus.h> /* types and numbers only: nothing of it is linked */

/* The functions called, with the types they have in talus.h. */
static const char *(*message)(void);
static const char *(*engine_message)(const talus_engine *);
static int32_t (*version)(void);
static talus_status (*settings_init)(talus_settings *);
static talus_status (*material_init)(talus_material *);
static talus_status (*contact_init)(talus_contact *);
static talus_status (*create)(const talus_settings *, talus_engine **);
static talus_status (*material_add)(talus_engine *, const talus_material *, int32_t *);
static talus_status (*contact_set)(talus_engine *, int32_t, int32_t, const talus_contact *);
static talus_status (*insert)(talus_engine *, const talus_particles *, double);
static talus_status (*step)(talus_engine *, int64_t, int64_t *);
static talus_status (*copy)(talus_engine *, int32_t, int64_t, void *, int64_t *);
static void (*destroy)(talus_engine *);

/* ISO C has no cast from dlsym's void * to a function; POSIX promises that the bits are the same. */
static int find(void *library, const char *name, void *out_function) {
    void *const symbol = dlsym(library, name);
    if (symbol == NULL) fprintf(stderr, "dlopen: %s\n", dlerror());
    memcpy(out_function, &symbol, sizeof symbol);
    return symbol != NULL;
}

static int find_all(void *library) {
    return find(library, "talus_message", &message) && find(library, "talus_engine_message", &engine_message) &&
           find(library, "talus_version", &version) && find(library, "talus_settings_init", &settings_init) &&
           find(library, "talus_material_init", &material_init) && find(library, "talus_contact_init", &contact_init) &&
           find(library, "talus_engine_create", &create) && find(library, "talus_material_add", &material_add) &&
           find(library, "talus_contact_set", &contact_set) && find(library, "talus_particles_insert", &insert) &&
           find(library, "talus_engine_step", &step) && find(library, "talus_particles_copy", &copy) &&
           find(library, "talus_engine_destroy", &destroy);
}

static talus_status fall(talus_engine *engine, double time_step, double *out_error) {
    static const int64_t label = 7, steps = 1000;
    static const double start[3] = {0.5, 0.9, 0.5}, radius = 0.01;
    const double time = (double)steps * time_step, expected = start[1] - 0.5 * 9.81 * time * time;
    talus_material glass;
    talus_contact contact;
    talus_particles grain = {sizeof grain, 0, 1, &label, start, &radius, NULL, NULL, NULL, NULL, NULL};
    double position[3];
    int32_t id;
    int64_t count;
    talus_status status;

    material_init(&glass);
    glass.young = 1e8, glass.poisson = 0.2, glass.density = 2500;
    if ((status = material_add(engine, &glass, &id)) < 0) return status;
    contact_init(&contact);
    contact.restitution = 0.9;
    if ((status = contact_set(engine, id, id, &contact)) < 0) return status;
    if ((status = insert(engine, &grain, 0.05)) < 0) return status;
    if ((status = step(engine, steps, NULL)) < 0) return status;
    if ((status = copy(engine, TALUS_FIELD_POSITION, 1, position, &count)) < 0) return status;
    *out_error = fabs(position[1] - expected);
    return TALUS_OK;
}

int main(int argc, char **argv) {
    void *const library = dlopen(argc > 1 ? argv[1] : "libtalus.so.0", RTLD_NOW | RTLD_LOCAL); /* the number is the ABI's */
    talus_settings settings;
    talus_engine *engine = NULL;
    talus_status status;
    double error = 1;

    if (library == NULL) return fprintf(stderr, "dlopen: %s\n", dlerror()), 1;
    if (!find_all(library)) return 1;
    if (version() / 10000 != TALUS_VERSION_MAJOR) return fprintf(stderr, "dlopen: library %d is of another ABI\n", (int)version()), 1;
    settings_init(&settings);
    settings.domain_lo[0] = settings.domain_lo[1] = settings.domain_lo[2] = 0;
    settings.domain_hi[0] = settings.domain_hi[1] = settings.domain_hi[2] = 1;
    settings.time_step = 5e-5;
    if ((status = create(&settings, &engine)) < 0) return fprintf(stderr, "dlopen: creating: %s\n", message()), 1;
    if ((status = fall(engine, settings.time_step, &error)) < 0) fprintf(stderr, "dlopen: falling: %s\n", engine_message(engine));
    destroy(engine);
    printf("library %d, off from g t^2 / 2 by %.1e m\n", (int)version(), error);
    /* Left open: threads and thread-local data of the libraries below Talus (TBB, MPI) outlive a dlclose badly. */
    return status < 0 || error > 1e-12;
}
