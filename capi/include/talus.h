/* talus.h: the C ABI of Talus, a discrete element method engine for spheres with friction in walls.
 *
 * Units      SI; angles in radian; [1] is a pure number.
 * Shape      vec3 arrays are n*3 doubles, x y z x y z ...; every count is a number of items, not bytes.
 * Ownership  the caller owns its buffers; they are read or filled during the call and no pointer is kept.
 * Threads    one engine takes one caller at a time; separate engines are independent.
 *            talus_engine_request_stop() alone may be called from anywhere, a signal handler included.
 * Ranks      [local] the calling rank only; [collective] every rank of the engine's communicator, in the same
 *            order, with the same arguments unless said. A serial engine is a communicator of one.
 * Errors     every function returns a talus_status: TALUS_OK (0), TALUS_STOPPED (1, from stepping), or a negative number that
 *            never changes its meaning. Outputs are untouched on failure unless said. _init functions fail for NULL only.
 *            The text of a failure is had, until the next call on the engine, from
 *            talus_engine_message() (by engine) or talus_message() (calling thread, for failed creates).
 *            The library never prints, exits, aborts, and never initialises or finalises MPI.
 * Structs    every struct begins with struct_size and is filled by its _init function before use; the library
 *            reads what the caller's size covers and takes defaults for the rest. Members without a default are to be set.
 *            In an array of structs the first one's struct_size tells how far apart they stand. A struct that has grown since
 *            the first header has an _init_sized, which its _init then stands for: the size is the program's.
 * Bits       the trajectory is a function of the physics alone: the same bits on any number of ranks and
 *            threads, any skin, tile size and rebalancing, and across checkpoints (x86-64 with AVX2 and FMA).
 */
#ifndef TALUS_H
#define TALUS_H

#include <stddef.h>
#include <stdint.h>

#if defined(TALUS_BUILD)
#define TALUS_API __attribute__((visibility("default")))
#else
#define TALUS_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define TALUS_VERSION_MAJOR 0
#define TALUS_VERSION_MINOR 1
#define TALUS_VERSION_PATCH 0
#define TALUS_VERSION_NUMBER (TALUS_VERSION_MAJOR * 10000 + TALUS_VERSION_MINOR * 100 + TALUS_VERSION_PATCH)

/* ---- status ------------------------------------------------------------------------------------------- */

typedef int32_t talus_status;

#define TALUS_OK 0
#define TALUS_ERR_ARGUMENT (-1)    /* an argument is wrong (state kept) */
#define TALUS_ERR_STATE (-2)       /* the call does not fit the engine's state, e.g. a poisoned engine */
#define TALUS_ERR_UNSTABLE (-3)    /* the simulation left its valid range: force cap, skin outrun, not finite */
#define TALUS_ERR_LOST (-4)        /* a grain left the domain */
#define TALUS_ERR_IO (-5)          /* a file could not be read or written, or is damaged */
#define TALUS_ERR_COMM (-6)        /* MPI failed */
#define TALUS_ERR_CAPACITY (-7)    /* out of memory or of an index range */
#define TALUS_ERR_UNSUPPORTED (-8) /* this machine or this build cannot do it */
#define TALUS_ERR_INTERNAL (-9)    /* a defect of the library: please report it */
#define TALUS_STOPPED 1            /* a requested stop was honoured; the engine is whole and may go on */

/** A short name of a status, e.g. "TALUS_ERR_IO"; never NULL. [local] */
TALUS_API const char *talus_status_string(talus_status status);
/** The text of the calling thread's last failure where no engine exists (failed creates, NULL handles); never
 *  NULL, empty if there was none; valid until the thread's next call. [local] */
TALUS_API const char *talus_message(void);
/** TALUS_VERSION_NUMBER of the library in use. [local] */
TALUS_API int32_t talus_version(void);
/** One line about the build: version, compiler, optimisation; never NULL. [local] */
TALUS_API const char *talus_build_info(void);

/* ---- settings ----------------------------------------------------------------------------------------- */

/* Normal law (docs: core/law/normal.hpp). */
#define TALUS_NORMAL_HERTZ 0
#define TALUS_NORMAL_LINEAR 1
/* Damping. CLIPPED: never attracts, and gives the restitution asked for. ATTRACTIVE: what LAMMPS and LIGGGHTS do. */
#define TALUS_DAMPING_CLIPPED 0
#define TALUS_DAMPING_ATTRACTIVE 1
/* Tangential law (core/law/tangential.hpp). */
#define TALUS_TANGENTIAL_FORCE_RESCALED 0 /* force history, rescaled when the contact radius shrinks */
#define TALUS_TANGENTIAL_FORCE 1          /* force history, not rescaled */
#define TALUS_TANGENTIAL_DISPLACEMENT 2   /* displacement history; gains up to 0.33 % energy at e = 1, mu 0.6 */
#define TALUS_TANGENTIAL_NONE 3           /* frictionless: no tangential force at all */
/* Rolling resistance (core/law/rolling.hpp). */
#define TALUS_ROLLING_NONE 0
#define TALUS_ROLLING_CONSTANT 1 /* type A: constant directional torque */
#define TALUS_ROLLING_SPRING 2   /* type C: elastic-plastic spring-dashpot */
/* Radius in the rolling torque. */
#define TALUS_ROLLING_RADIUS_EFFECTIVE 0 /* R* = Ri Rj / (Ri + Rj) */
#define TALUS_ROLLING_RADIUS_OWN 1       /* each grain's own radius; type A only */
/* Rebalancing of subdomains at list rebuilds; changes no bits. */
#define TALUS_REBALANCE_OFF 0
#define TALUS_REBALANCE_AUTO 1   /* when imbalance has cost more than moving the cuts does */
#define TALUS_REBALANCE_EVERY 2  /* at every rebuild, or every settings.rebalance_interval of them */
#define TALUS_REBALANCE_RANDOM 3 /* random cuts, as often (for tests) */

typedef struct talus_laws {
    uint32_t struct_size;
    int32_t normal;          /* TALUS_NORMAL_*      default HERTZ */
    int32_t damping;         /* TALUS_DAMPING_*     default CLIPPED */
    int32_t tangential;      /* TALUS_TANGENTIAL_*  default FORCE_RESCALED */
    int32_t rolling;         /* TALUS_ROLLING_*     default CONSTANT */
    int32_t rolling_radius;  /* TALUS_ROLLING_RADIUS_*  default EFFECTIVE */
    int32_t tangential_damping; /* 1 (default): with the damping of physics; 0: none */
    int32_t reserved;
    double rolling_rate;     /* [rad/s] > 0, type A: rate below which the torque falls to zero (or the rate that one step of it stops, if larger); bounds creep. default 1e-3 */
    double rolling_damping;  /* [1] >= 0, type C: fraction of critical damping eta_r. default 0.3 */
    double stiffness_n;      /* [N/m] > 0, linear law: normal stiffness k of every contact */
    double stiffness_t;      /* [N/m] >= 0, linear law; 0 (default): 2/7 of stiffness_n */
} talus_laws;

typedef struct talus_settings {
    uint32_t struct_size;
    int32_t header_version;  /* set by _init: TALUS_VERSION_NUMBER of the header compiled against */
    double domain_lo[3];     /* [m] lower corner of the domain; no default */
    double domain_hi[3];     /* [m] upper corner, above the lower one; no default */
    int32_t periodic[3];     /* 0 or 1 for x, y, z; default 0. A periodic length below 2 (d_max + skin) is refused,
                              * with an automatic skin 2.2 d_max */
    int32_t threads;         /* > 0 worker threads of this rank; default 1 */
    double gravity[3];       /* [m/s^2] default 0 -9.81 0: y is up */
    double time_step;        /* [s] > 0; no default. See talus_engine_critical_step() */
    double time_step_limit;  /* [1] refuse a step above this fraction of the Rayleigh step; default 0.5 */
    double skin;             /* [m] list skin, pinned if > 0; 0 (default): automatic. It is then 0.1 of the largest diameter
                              * at first, and at rebuilds of the lists moves to where a step takes least time, in 0.02 to 0.5
                              * diameters and within the room of the domain. Changes no bits, but as it depends on measured
                              * times, rebuilds and migrations differ from run to run. Not part of a checkpoint */
    double radius_max;       /* [m] largest radius that will ever be inserted; 0 (default): that of the grains at first step */
    int32_t tile_grains;     /* grains aimed at in a tile; 0 (default): chosen. Changes no bits */
    int32_t rebalance;       /* TALUS_REBALANCE_*; default AUTO */
    int32_t rank_grid[3];    /* subdomains along x, y, z; 0 (default): chosen for the grains, anew when cuts move and it spares a fifth of the halos. The product must be the rank count */
    int32_t energy_ledger;   /* 1: account dissipated energy every step (costs a tenth); default 0 */
    uint64_t seed;           /* random numbers of this engine (packing, random cuts); default 1 */
    talus_laws laws;
    int32_t rebalance_interval; /* >= 1: rebuilds between two moves of cuts with REBALANCE_EVERY and _RANDOM; default 1 */
    int32_t reserved;
} talus_settings;

/** Fill with the defaults named above. [local] */
TALUS_API talus_status talus_laws_init(talus_laws *out_laws);
/** Fill with the defaults named above; domain and time step are left NaN and must be given. [local] */
TALUS_API talus_status talus_settings_init(talus_settings *out_settings);
/** The same for a struct of this size: what a program compiled against another header has. [local] */
TALUS_API talus_status talus_settings_init_sized(talus_settings *out_settings, size_t struct_size);
#define talus_settings_init(out_settings) talus_settings_init_sized((out_settings), sizeof(talus_settings))

/* ---- life cycle --------------------------------------------------------------------------------------- */

typedef struct talus_engine talus_engine;

/** Create a serial engine; works without MPI. [local]
 *  @return TALUS_OK | ARGUMENT (every fault is listed in talus_message()) | UNSUPPORTED (CPU without AVX2 or FMA) */
TALUS_API talus_status talus_engine_create(const talus_settings *settings, talus_engine **out_engine);
/** Create an engine over a communicator. [collective: same settings on every rank]
 *  @param comm_f  Fortran handle (MPI_Comm_c2f); talus_mpi.h takes an MPI_Comm. The library duplicates it and
 *                 sets ERRORS_RETURN on its duplicate only. MPI must be initialised with thread level
 *                 MPI_THREAD_SERIALIZED or more and outlive the engine. */
TALUS_API talus_status talus_engine_create_mpi(const talus_settings *settings, int32_t comm_f, talus_engine **out_engine);
/** Free everything; NULL is fine. Talks to no other rank except to free the communicator of a healthy engine.
 *  [collective for a healthy parallel engine, else local] */
TALUS_API void talus_engine_destroy(talus_engine *engine);
/** The text of the engine's last failure, the same on every rank for a collective call; never NULL; valid until
 *  the next call on the engine, any call, which empties it. [local] */
TALUS_API const char *talus_engine_message(const talus_engine *engine);
/** @param out_rank, out_ranks may be NULL [local] */
TALUS_API talus_status talus_engine_rank(const talus_engine *engine, int32_t *out_rank, int32_t *out_ranks);

/** The subdomains along x, y and z that a run on so many ranks has (settings.rank_grid chosen: least halos), for planning one.
 *  @param lengths [m] > 0, of the grains; a periodic axis whole @param periodic 0 or 1 for x, y, z; NULL: all 0 @param given subdomains along an axis where > 0, chosen where 0; NULL: all chosen
 *  @return ARGUMENT if the given axes do not divide the ranks [local] */
TALUS_API talus_status talus_rank_grid(const double lengths[3], const int32_t periodic[3], int32_t ranks, const int32_t given[3], int32_t out_grid[3]);

/** Change the contact laws between steps. If the tangential or rolling law changes, all contact histories start
 *  anew from zero. [collective] */
TALUS_API talus_status talus_engine_set_laws(talus_engine *engine, const talus_laws *laws);
/** Change the time step between steps; checked at the next step. [collective] */
TALUS_API talus_status talus_engine_set_time_step(talus_engine *engine, double time_step);
/** @param gravity [m/s^2] [collective] */
TALUS_API talus_status talus_engine_set_gravity(talus_engine *engine, const double gravity[3]);
/** The Rayleigh step of the present grains (smallest over them), physics of Li et al.: pi R sqrt(rho/G) /
 *  (0.1631 nu + 0.8766). A usual time step is 0.1 to 0.2 of it. @param out_step [s]; infinity without grains. [collective] */
TALUS_API talus_status talus_engine_critical_step(talus_engine *engine, double *out_step);

/* ---- materials ---------------------------------------------------------------------------------------- */

typedef struct talus_material {
    uint32_t struct_size;
    int32_t rigid;       /* 1: infinitely stiff (walls only); young and poisson are then ignored; default 0 */
    double young;        /* [Pa] > 0; no default, as for the two below */
    double poisson;      /* [1] 0 <= nu < 0.5 */
    double density;      /* [kg/m^3] > 0; not used for walls */
} talus_material;

typedef struct talus_contact {
    uint32_t struct_size;
    int32_t reserved;
    double restitution;      /* [1] 0.05 <= e <= 1; no default */
    double friction;         /* [1] >= 0, Coulomb; default 0 */
    double rolling_friction; /* [1] >= 0; default 0 */
} talus_contact;

TALUS_API talus_status talus_material_init(talus_material *out_material);
TALUS_API talus_status talus_contact_init(talus_contact *out_contact);
/** Add a material before the first step. @param out_id 0, 1, 2 ... at most 16; may be NULL. [collective] */
TALUS_API talus_status talus_material_add(talus_engine *engine, const talus_material *material, int32_t *out_id);
/** Set what two materials do in touch; order does not matter; may be called again between steps. Every pair that
 *  can meet must be set before the first step. [collective] */
TALUS_API talus_status talus_contact_set(talus_engine *engine, int32_t material_a, int32_t material_b, const talus_contact *contact);

/* ---- walls -------------------------------------------------------------------------------------------- */

typedef struct talus_wall {
    uint32_t struct_size;
    int32_t material;   /* an id; default 0 */
    double point[3];    /* [m] a point of the plane; default 0 0 0 */
    double normal[3];   /* [1] towards the grains; normalised by the library; no default */
    double velocity[3]; /* [m/s] of the plane: along the normal it moves, within the plane it drags; default 0 0 0 */
} talus_wall;

typedef struct talus_wall_state {
    uint32_t struct_size;
    int32_t contacts;   /* grains in touch */
    double point[3];    /* [m] now */
    double velocity[3]; /* [m/s] */
    double force[3];    /* [N] of the grains on the wall, last force evaluation: positions at the end of the last step, velocities at its half */
    double torque[3];   /* [N m] about the origin */
    double work;        /* [J] done by the wall on the grains since the start */
} talus_wall_state;

TALUS_API talus_status talus_wall_init(talus_wall *out_wall);
TALUS_API talus_status talus_wall_state_init(talus_wall_state *out_state);
/** Add an unbounded plane before the first step; at most 32. @param out_id 0, 1, 2 ..., may be NULL [collective] */
TALUS_API talus_status talus_wall_add(talus_engine *engine, const talus_wall *wall, int32_t *out_id);
/** The wall moves at this velocity [m/s] from the next step on; what talus_wall_get() tells of forces does not change before. [collective] */
TALUS_API talus_status talus_wall_set_velocity(talus_engine *engine, int32_t wall, const double velocity[3]);
/** Same values on every rank. [collective] */
TALUS_API talus_status talus_wall_get(talus_engine *engine, int32_t wall, talus_wall_state *out_state);

/* ---- particles ---------------------------------------------------------------------------------------- */

typedef struct talus_particles {
    uint32_t struct_size;
    int32_t reserved;
    int64_t count;                  /* number of grains given by this rank; may be 0 */
    const int64_t *label;           /* [count] >= 0, unique over all ranks and for ever, below 2^62 */
    const double *position;         /* [count*3] m, within the domain */
    const double *radius;           /* [count] m, > 0 */
    const double *velocity;         /* [count*3] m/s, or NULL for zero */
    const double *angular_velocity; /* [count*3] rad/s, or NULL for zero */
    const int32_t *material;        /* [count] ids, or NULL for 0 */
    const int32_t *group;           /* [count] 0..15, or NULL for 0 */
    const int32_t *colour;          /* [count] 0..255, carried for pictures, or NULL for 0 */
} talus_particles;

#define TALUS_GROUP_FREE 0   /* moved by forces (default) */
#define TALUS_GROUP_FROZEN 1 /* does not move */
#define TALUS_GROUP_DRIVEN 2 /* moves at the velocity given, whatever pushes */

TALUS_API talus_status talus_particles_init(talus_particles *out_particles);
/** Insert grains; any rank may give any of them: each is sent to its owner. All faults (label given twice, outside
 *  the domain, not finite, overlap above `max_overlap` of the smaller radius) are checked before any change.
 *  @param max_overlap [1] 0 <= f <= 1, e.g. 0.05 [collective: own particles on each rank] */
TALUS_API talus_status talus_particles_insert(talus_engine *engine, const talus_particles *particles, double max_overlap);

typedef struct talus_fill {
    uint32_t struct_size;
    int32_t material;
    double lo[3], hi[3];       /* [m] box to fill; grain surfaces stay inside on non-periodic axes */
    double radius_min, radius_max; /* [m] uniform in radius between them */
    int64_t count;             /* grains wanted at most; <= 0: as many as there are places */
    int64_t first_label;       /* labels are first_label + lattice place */
    double jitter;             /* [1] 0..1, random displacement as a share of the room in a lattice place; default 1 */
    double room;               /* [1] >= 0: lattice spacing is (2 radius_max) * (1 + room); default 0.1 */
    int32_t group, reserved;
} talus_fill;

TALUS_API talus_status talus_fill_init(talus_fill *out_fill);
/** Fill a box at random without overlaps, layer by layer upwards (against gravity's largest component): grains on
 *  a jittered lattice, each place's random numbers keyed by seed and place (Philox4x32-10), so that the bed does not
 *  depend on ranks. Labels go up to first_label plus the number of lattice places in the box: for several fills give each a range
 *  of its own, say 2^40 apart. Fewer grains than asked for are no failure.
 *  @param out_count grains placed in all, may be NULL [collective] */
TALUS_API talus_status talus_particles_fill(talus_engine *engine, const talus_fill *fill, int64_t *out_count);

/** Set how a group moves. velocity and angular_velocity are read for DRIVEN (NULL: zero). [collective] */
TALUS_API talus_status talus_group_set(talus_engine *engine, int32_t group, int32_t mode, const double velocity[3], const double angular_velocity[3]);
/** Add one velocity to every free grain (a bed that starts co-moving with its floor). [collective] */
TALUS_API talus_status talus_particles_add_velocity(talus_engine *engine, const double velocity[3]);
/** Set every free grain's velocity and spin to zero. [collective] */
TALUS_API talus_status talus_particles_stop(talus_engine *engine);
/** Colour by horizontal layers of equal thickness: colour = floor((x.axis - origin)/thickness) mod 256. [collective]
 *  @param axis 0 x, 1 y, 2 z */
TALUS_API talus_status talus_particles_colour_layers(talus_engine *engine, int32_t axis, double origin, double thickness);
/** Remove grains whose centre lies above `level` along `axis`; their contacts end. @param out_removed over all ranks, may be NULL [collective] */
TALUS_API talus_status talus_particles_remove_above(talus_engine *engine, int32_t axis, double level, int64_t *out_removed);
/** Remove grains whose centre lies in a box, lo <= x < hi; their contacts end. @param out_removed over all ranks, may be NULL [collective] */
TALUS_API talus_status talus_particles_remove_box(talus_engine *engine, const double lo[3], const double hi[3], int64_t *out_removed);
/** Remove grains by label, whichever rank holds them and whichever rank names them (several may name one); their contacts end.
 *  @param labels [count], may be NULL if count is 0 @param out_removed over all ranks, may be NULL
 *  @return ARGUMENT if there is no grain of a label (nothing is removed then) [collective: own labels on each rank] */
TALUS_API talus_status talus_particles_remove(talus_engine *engine, int64_t count, const int64_t *labels, int64_t *out_removed);
/** Take the present positions as the origin of the displacement field. [collective] */
TALUS_API talus_status talus_particles_mark_reference(talus_engine *engine);

/* ---- stepping ----------------------------------------------------------------------------------------- */

/** Advance by whole steps (velocity Verlet). [collective: same n_steps]
 *  @param n_steps   [1] >= 0; zero only prepares (checks, lists, first forces)
 *  @param out_done  [1] steps finished on all ranks, may be NULL; written on failure too
 *  @return TALUS_OK | TALUS_STOPPED (talus_engine_request_stop) | ARGUMENT (state kept; also when laws, materials, walls,
 *          groups or other settings differ between ranks) | UNSTABLE, LOST, COMM, INTERNAL, and IO from a trace that could
 *          not be written: the engine is poisoned, only messages, observation of counts and destroy still work */
TALUS_API talus_status talus_engine_step(talus_engine *engine, int64_t n_steps, int64_t *out_done);
/** Step until `time` is reached: the last step ends there or less than a step beyond it; a millionth of a step short of it counts as
 *  there. Otherwise as talus_engine_step. @param time [s]; not later than now: nothing is done [collective: same time] */
TALUS_API talus_status talus_engine_advance_to(talus_engine *engine, double time, int64_t *out_done);
/** Ask the running or the next step call to return TALUS_STOPPED after its current step, on every rank (also if that was its
 *  last one). One atomic store. [local] */
TALUS_API void talus_engine_request_stop(talus_engine *engine);

/* ---- observing ---------------------------------------------------------------------------------------- */

typedef struct talus_state {
    uint32_t struct_size;
    int32_t threads;          /* asked for on this rank */
    int32_t threads_observed; /* distinct threads seen at work in the task graph, least over ranks */
    int32_t ranks;
    int64_t step;             /* steps since the start, checkpoints included */
    double time;              /* [s] */
    int64_t particles;        /* over all ranks */
    int64_t local_particles;
    int64_t ghosts;           /* on this rank */
    int64_t contacts;         /* touching pairs of grains, each once, over all ranks */
    int64_t wall_contacts;
    int64_t sliding_contacts; /* of both kinds, at the Coulomb limit in the last step */
    int64_t rebuilds;         /* list rebuilds since creation */
    int64_t rebalances;       /* rebuilds at which cuts moved */
    int64_t migrations;       /* grains that changed rank, over all ranks */
    double imbalance;         /* [1] max/mean of busy time over ranks since the last rebuild */
    double skin;              /* [m] of the present lists */
    double bytes_per_particle;/* largest over ranks of engine bytes / grains */
    double kinetic_energy;    /* [J] translation and rotation, driven grains included */
    double max_speed;         /* [m/s] likewise */
    double unbalanced_force;  /* [1] mean |net force| of free grains / mean |contact force|; 0 without contacts */
    double max_overlap;       /* [1] largest overlap / smaller radius among contacts of grains */
    uint64_t digest_lo, digest_hi; /* order-free 128-bit digest of the whole state */
    int64_t halo_messages;    /* that all ranks together send in a step, with the present lists */
    int64_t halo_bytes;       /* ... and their bytes */
} talus_state;

TALUS_API talus_status talus_state_init(talus_state *out_state);
/** The same for a struct of this size. [local] */
TALUS_API talus_status talus_state_init_sized(talus_state *out_state, size_t struct_size);
#define talus_state_init(out_state) talus_state_init_sized((out_state), sizeof(talus_state))
/** Everything above, agreed over ranks. Costs about a force evaluation. Like all that looks at contacts (energy, stress, contacts), it
 *  first prepares an engine whose grains or walls have changed, as talus_engine_step(engine, 0) would; views are then stale. [collective] */
TALUS_API talus_status talus_engine_state(talus_engine *engine, talus_state *out_state);

typedef struct talus_rank {
    uint32_t struct_size;
    int32_t rank;
    double lo[3], hi[3];    /* [m] its subdomain; outer ones end with the domain */
    int64_t particles, ghosts;
    int64_t halo_messages;  /* that it sends in a step */
    int64_t halo_bytes;     /* ... and their bytes */
    int32_t tiles;
    int32_t threads;
    double busy;            /* [s] of each of its threads in a step, in the mean since the lists were built; 0 before the first step */
} talus_rank;
TALUS_API talus_status talus_rank_init(talus_rank *out_rank);
/** What each rank holds, sends and takes, the same on every rank.
 *  @param io_count capacity in, ranks out @param out_ranks the struct_size of the first one (talus_rank_init) tells how far apart they stand @return ARGUMENT if the capacity is too small (*io_count is then written) [collective] */
TALUS_API talus_status talus_engine_ranks(talus_engine *engine, int32_t *io_count, talus_rank *out_ranks);

typedef struct talus_energy {
    uint32_t struct_size;
    int32_t reserved;
    double kinetic, rotational; /* [J] */
    double elastic_normal, elastic_tangential, elastic_rolling; /* [J] stored in contacts */
    double gravity;             /* [J] -sum m g.x, origin 0; periodic axes with gravity along them drift */
    double wall_work;           /* [J] done by walls on grains since the start */
    double friction, damping, rolling; /* [J] dissipated since the start; need settings.energy_ledger */
} talus_energy;
TALUS_API talus_status talus_energy_init(talus_energy *out_energy);
/** Energies now, order-free sums: same bits on any ranks. [collective] */
TALUS_API talus_status talus_engine_energy(talus_engine *engine, talus_energy *out_energy);
/** Mean stress tensor over a box by the contact and kinetic terms (Love-Weber), compression negative.
 *  @param out_stress [Pa] 9 doubles row major @param out_solid_fraction [1] grain volume with centre in the box / box volume
 *  @param out_coordination [1] mean contacts of grains with centre in the box, may be NULL [collective] */
TALUS_API talus_status talus_engine_stress(talus_engine *engine, const double lo[3], const double hi[3], double out_stress[9], double *out_solid_fraction, double *out_coordination);
/** Integer sum of all internal (grain on grain) forces of the last evaluation, in fixed-point units: always 0 0 0.
 *  @param out_sum 3 numbers @param out_unit [N] [collective] */
TALUS_API talus_status talus_engine_internal_force_sum(talus_engine *engine, int64_t out_sum[3], double *out_unit);

/* Fields of grains. Shape and type of each: */
#define TALUS_FIELD_LABEL 0            /* int64 */
#define TALUS_FIELD_POSITION 1         /* double x3, m */
#define TALUS_FIELD_RADIUS 2           /* double, m */
#define TALUS_FIELD_VELOCITY 3         /* double x3, m/s */
#define TALUS_FIELD_ANGULAR_VELOCITY 4 /* double x3, rad/s */
#define TALUS_FIELD_FORCE 5            /* double x3, N: sum of contact forces of the last evaluation (no gravity) */
#define TALUS_FIELD_TORQUE 6           /* double x3, N m */
#define TALUS_FIELD_MASS 7             /* double, kg */
#define TALUS_FIELD_MATERIAL 8         /* int32 */
#define TALUS_FIELD_GROUP 9            /* int32 */
#define TALUS_FIELD_COLOUR 10          /* int32 */
#define TALUS_FIELD_DISPLACEMENT 11    /* double x3, m since talus_particles_mark_reference, periodic wraps undone */
#define TALUS_FIELD_OWNER 12           /* int32 rank */

/** Copy a field of this rank's grains ordered by label. [local]
 *  @param capacity items that fit out_data @param out_data type and components as listed @param out_count grains of this rank
 *  @return ARGUMENT if capacity is too small (out_count is then written) */
TALUS_API talus_status talus_particles_copy(talus_engine *engine, int32_t field, int64_t capacity, void *out_data, int64_t *out_count);
/** Gather a field of all grains ordered by label to rank 0; other ranks get count 0, and may give capacity 0 and NULL. A capacity of
 *  rank 0 that is too small is the error of all. [collective: same field] */
TALUS_API talus_status talus_particles_gather(talus_engine *engine, int32_t field, int64_t capacity, void *out_data, int64_t *out_count);

/* Fields of contacts that touch, each contact once. i is the grain with the smaller label; j is the other grain, or TALUS_WALL_LABEL
 * plus the id of a wall. Forces are what the law gives for the positions, velocities and histories of now: the forces of the last
 * evaluation but for the half step that velocities have made since. Same bits on any ranks. */
#define TALUS_CONTACT_LABELS 0  /* int64 x2: i and j */
#define TALUS_CONTACT_FORCE 1   /* double x3, N on i */
#define TALUS_CONTACT_NORMAL 2  /* double x3, unit vector from j to i */
#define TALUS_CONTACT_POINT 3   /* double x3, m: the middle of the overlap, within the domain */
#define TALUS_CONTACT_OVERLAP 4 /* double, m */
#define TALUS_CONTACT_SLIDING 5 /* int32: 1 at the Coulomb limit in the last step */
#define TALUS_WALL_LABEL (INT64_C(1) << 62)

/** Copy a field of the contacts whose grain i this rank holds, ordered by i, then j. [collective: same field]
 *  @param capacity items that fit out_data; a rank that gives 0 only asks how many there are @param out_data type and components as listed
 *  @param out_count contacts of this rank @return ARGUMENT on all ranks if a capacity above 0 is too small (out_count is then written) */
TALUS_API talus_status talus_contacts_copy(talus_engine *engine, int32_t field, int64_t capacity, void *out_data, int64_t *out_count);

typedef struct talus_view {
    uint32_t struct_size;
    int32_t components;   /* 1 or 3 */
    int64_t count;        /* grains of this rank, in slot order */
    int64_t stride;       /* bytes from one grain to the next */
    const double *data;   /* first component of the first grain; const: never write; not to be read when count is 0 */
    uint64_t generation;  /* stale as soon as talus_engine_generation() differs */
} talus_view;
TALUS_API talus_status talus_view_init(talus_view *out_view);
/** View a field without a copy: POSITION, RADIUS, VELOCITY, ANGULAR_VELOCITY or MASS. Valid until the next mutating call. [local] */
TALUS_API talus_status talus_particles_view(talus_engine *engine, int32_t field, talus_view *out_view);
/** A number that changes whenever views become stale: stepping, inserting, removing, setting velocities, restoring. [local] */
TALUS_API talus_status talus_engine_generation(const talus_engine *engine, uint64_t *out_generation);

typedef struct talus_phase {
    uint32_t struct_size;
    int32_t reserved;
    char name[24];            /* binning, pair_build, force, integrate, halo_exchange, rebalance, observe */
    double min, mean, max;    /* [s] over ranks, busy time summed over threads */
    int64_t calls;            /* nodes run on this rank */
} talus_phase;
TALUS_API talus_status talus_phase_init(talus_phase *out_phase);
/** Busy time of each phase since creation. @param io_count capacity in, phases out
 *  @param out_phases the struct_size of the first one (talus_phase_init) tells how far apart they stand
 *  @return ARGUMENT if the capacity is too small (*io_count is then written) [collective] */
TALUS_API talus_status talus_engine_phases(talus_engine *engine, int32_t *io_count, talus_phase *out_phases);

typedef struct talus_memory {
    uint32_t struct_size;
    int32_t reserved;
    int64_t records;   /* [bytes] grains, ghosts, and where they were listed */
    int64_t cells;     /* [bytes] which grain stands where */
    int64_t sums;      /* [bytes] forces and torques */
    int64_t pairs;     /* [bytes] contacts and candidates */
    int64_t histories; /* [bytes] of contacts */
    int64_t rebuild;   /* [bytes] kept for the next rebuild of the lists */
} talus_memory;
TALUS_API talus_status talus_memory_init(talus_memory *out_memory);
/** What this rank's engine holds now, used or not; messages and HDF5's own memory are not in it. [local] */
TALUS_API talus_status talus_engine_memory(talus_engine *engine, talus_memory *out_memory);

/* ---- files -------------------------------------------------------------------------------------------- */

/** Write the whole state to one HDF5 file (temporary name, flush, rename). [collective] */
TALUS_API talus_status talus_checkpoint_save(talus_engine *engine, const char *path);
/** Create an engine from a checkpoint, on any number of ranks. Physics comes from the file; of `settings` only
 *  threads, skin, tile_grains, rebalance, rebalance_interval and rank_grid are used, and the others may stay as _init left them. [collective]
 *  @param comm_f as talus_engine_create_mpi, or TALUS_SERIAL for a serial engine */
#define TALUS_SERIAL INT32_MIN
TALUS_API talus_status talus_checkpoint_load(const char *path, const talus_settings *settings, int32_t comm_f, talus_engine **out_engine);
typedef struct talus_kept talus_kept;
/** Keep the whole state in memory (what a checkpoint holds, each rank its own part), to come back to it as often as wanted: implicit
 *  coupling tries a step more than once. Costs about a rebuild of the lists and a second copy of grains and contacts.
 *  @param out_kept the caller's, to be given to talus_kept_destroy() on every rank [collective] */
TALUS_API talus_status talus_engine_keep(talus_engine *engine, talus_kept **out_kept);
/** Go back to a state that this engine kept; laws, walls, materials, groups, time step and clock included. Lists are built anew at the next
 *  call that needs them. The same bits follow as did the first time. @return ARGUMENT (state kept) if it is another engine's [collective] */
TALUS_API talus_status talus_engine_restore(talus_engine *engine, const talus_kept *kept);
/** Free a kept state; NULL is fine, and so is an engine that is gone. [local] */
TALUS_API void talus_kept_destroy(talus_kept *kept);
/** Write a snapshot for ParaView (VTKHDF UnstructuredGrid; use the extension .hdf): one vertex a grain with label,
 *  radius, velocity, displacement, colour, owner. [collective] */
TALUS_API talus_status talus_snapshot_write(talus_engine *engine, const char *path);
/** Record the task graph's timeline of the next `steps` steps and write it in Chrome trace format, one process a
 *  rank, one row a worker, when they are done. [collective] */
TALUS_API talus_status talus_trace_start(talus_engine *engine, const char *path, int64_t steps);

#ifdef __cplusplus
}
#endif
#endif /* TALUS_H */
