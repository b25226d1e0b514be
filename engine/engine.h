/* The engine: discs, their contacts, walls and drives in two dimensions.
 *
 * It knows no file, no study and no statistic. A caller fills a struct rk_scene_spec, adds walls
 * and grains, steps, and looks at the scene through `const` functions, which cannot alter a run.
 *
 * Units: lengths in the mean grain diameter d, g = 1, masses so that a grain of radius R has
 * m = R^2 (areal density 1/pi; Martins 2021, ch. 5); hence times in sqrt(d/g). Angles in radians,
 * counter-clockwise. x to the right, y up.
 *
 * Equations: the pair law is in engine/contact.h, the integrator in engine/kernel.h.
 *
 * The same bytes: the trajectory depends on the spec, the walls and the grains only. It does not
 * depend on the neighbour method, on its skin, on the vector width of the processor, on whether
 * anybody looked, nor on whether the scene was packed and unpacked on the way.
 *
 * Threads: one scene belongs to one thread at a time; different scenes are independent.
 */
#ifndef RK_ENGINE_ENGINE_H
#define RK_ENGINE_ENGINE_H

#include "engine/spec.h"

/* ---- Life of a scene --------------------------------------------------------------------- */

struct rk_scene;

/* A scene without grains or walls; *scene is the caller's, free with rk_scene_free.
 * RK_EINVALID (with err->subject where a parameter is at fault), RK_EMEMORY. */
enum rk_status rk_scene_create(const struct rk_scene_spec *spec, struct rk_scene **scene,
                               struct rk_error *err);
void rk_scene_free(struct rk_scene *scene); /* NULL is fine */

/* Add a material, before grains and walls that use it: its number goes to *material.
 * RK_EINVALID: too many, a value negative or not finite, grains are there already. */
enum rk_status rk_scene_add_material(struct rk_scene *scene, const struct rk_material *properties,
                                     size_t *material, struct rk_error *err);

/* Add a grain, also between two steps, or, before the first step, a wall. Its number is the count
 * before: 0, 1, 2, ...
 * A grain keeps that number ("tag") for life. RK_EINVALID: no room, non-finite, radius or mass not
 * positive, mass or moment of inertia too small to divide by, lighter than spec.smallest, normal
 * not of length one. Whether two grains lie on the same point is seen at the first step. */
enum rk_status rk_scene_add_grain(struct rk_scene *scene, const struct rk_grain *grain,
                                  struct rk_error *err);
enum rk_status rk_scene_add_wall(struct rk_scene *scene, const struct rk_wall_spec *wall,
                                 struct rk_error *err);

/* Add a group, before the grains: its number, 1, 2, ..., goes to *group. RK_EINVALID: too many, a
 * drive with a fault, grains are there already. */
enum rk_status rk_scene_add_group(struct rk_scene *scene, const struct rk_group_spec *group,
                                  size_t *number, struct rk_error *err);

/* Add a growth, before the grains: its number, 1, 2, ..., goes to *number. RK_EINVALID: too many,
 * no numbers, grains are there already. */
enum rk_status rk_scene_add_growth(struct rk_scene *scene, const struct rk_growth_spec *growth,
                                   size_t *number, struct rk_error *err);

/* A row of grains like `each` along a segment, an arc or a polygon, of which shape and its numbers
 * count: on every vertex, and between two, or along an arc, at equal distances of at most `spacing`
 * (along an arc, of its length). How many that takes: 0 when the shape or the spacing has a fault.
 * RK_EINVALID: such a fault, no room, whatever is wrong with `each`. */
size_t rk_row_count(const struct rk_wall_spec *along, double spacing);
enum rk_status rk_scene_add_row(struct rk_scene *scene, const struct rk_wall_spec *along,
                                double spacing, const struct rk_grain *each, struct rk_error *err);

/* Advance by `steps` time steps. RK_EUNSTABLE when the state has become nonsense: the message
 * names the time, the grain, the value and the largest stable dt; the scene stays as it was found.
 * The check is made every spec.health.every steps, and as much oftener as it takes for no grain to
 * pass through another between two checks; when that is depends on the state alone.
 * RK_EINVALID when the first step finds what cannot be: two grains on the same point, a periodic
 * box too narrow for the grains or for a wall, more pairs than all-pairs can number. RK_EMEMORY. */
enum rk_status rk_scene_step(struct rk_scene *scene, uint64_t steps, struct rk_error *err);

/* Between two phases of one run (a settled bed begins to be shaken): the clock goes back to step
 * 0 and the time step changes, or a wall or group gets another drive, or a grain is held or let go.
 * Contacts and their history live on. A released grain starts at rest. A wall or group is at once
 * where its new drive has it: if that is somewhere else it jumps, and what this does to the springs
 * of its contacts is in no account of the ledger, but in its residual. */
enum rk_status rk_scene_restart_clock(struct rk_scene *scene, double dt, struct rk_error *err);
enum rk_status rk_scene_set_drive(struct rk_scene *scene, size_t wall,
                                  const struct rk_drive_spec *drive, struct rk_error *err);
enum rk_status rk_scene_set_group_drive(struct rk_scene *scene, size_t group,
                                        const struct rk_drive_spec *drive, struct rk_error *err);
enum rk_status rk_scene_hold(struct rk_scene *scene, uint32_t tag, bool held, struct rk_error *err);

/* Another gravity from now on; a switched one counts the time of the clock. RK_EINVALID. */
enum rk_status rk_scene_set_gravity(struct rk_scene *scene, const struct rk_gravity_spec *gravity,
                                    struct rk_error *err);

/* Between two steps: as many threads from here on; the bytes are the same. RK_EINVALID, RK_EMEMORY:
 * it stays as it was. */
enum rk_status rk_scene_set_threads(struct rk_scene *scene, size_t threads, struct rk_error *err);

/* The gravity that the forces of the last step felt. */
void rk_scene_gravity(const struct rk_scene *scene, double gravity[2]);

/* The largest stable time step of this scene: rk_stable_step of the stiffest pair of its materials
 * and of its body; and what its servo lids allow with the grains that they touch at present (at
 * least one each): a lid of mass M with n contacts moves with w^2 <= 2 n kn/M. */
double rk_scene_stable_step(const struct rk_scene *scene);

/* Go on with another neighbour method (out of rk_neighbour_registry): the bytes are the same. */
void rk_scene_set_neighbours(struct rk_scene *scene, const struct rk_piece *method);

/* Multiply all velocities by `keep` (0 to 1): a drag, for beds that should come to rest. The ledger
 * has what that takes as damping. */
void rk_scene_slow_down(struct rk_scene *scene, double keep);

/* ---- Looking at a scene ------------------------------------------------------------------ */

size_t rk_scene_grains(const struct rk_scene *scene);
size_t rk_scene_walls(const struct rk_scene *scene);
size_t rk_scene_groups(const struct rk_scene *scene);
uint64_t rk_scene_steps(const struct rk_scene *scene);
double rk_scene_time(const struct rk_scene *scene); /* steps * dt */
const struct rk_scene_spec *rk_scene_spec(const struct rk_scene *scene);
bool rk_scene_rotates(const struct rk_scene *scene); /* false without friction */

/* The grain of that tag. Its x lies in [0, period_x) where the box is periodic. */
enum rk_status rk_scene_grain(const struct rk_scene *scene, uint32_t tag, struct rk_grain *grain,
                              struct rk_error *err);

/* All grains in order of their tags, as float32 or float64 columns of `rk_scene_grains` entries,
 * each NULL if not wanted. position and velocity are [grain][2]. */
struct rk_snapshot {
    float *position, *velocity; /* [n][2] */
    float *angle, *omega;       /* [n]; zero where nothing rotates */
    double *radius, *mass;      /* [n] */
};
void rk_scene_snapshot(const struct rk_scene *scene, const struct rk_snapshot *out);

/* The touching pairs of the last step, in the order in which they were summed. `second` of a wall
 * contact is the wall's number and `wall` is true. The force acts on `second` (on the wall),
 * normal pointing from first to second; tangent = normal turned +90 degrees. */
struct rk_contact {
    uint32_t first, second;
    bool wall;
    double normal[2];
    double overlap;
    double fn, ft;
};
size_t rk_scene_contacts(const struct rk_scene *scene);
void rk_scene_contact(const struct rk_scene *scene, size_t i, struct rk_contact *contact);

/* Displacement and velocity of a wall at the present time, force of the grains on it at the last
 * step; each [2], NULL if not wanted. */
void rk_scene_wall(const struct rk_scene *scene, size_t wall, double displacement[2],
                   double velocity[2], double force[2]);

/* The rest of a wall's pose and load: its angle and angular velocity, and the torque of the grains
 * on it about its pivot at the last step. */
struct rk_wall_turn {
    double angle, velocity, torque;
};
struct rk_wall_turn rk_scene_wall_turn(const struct rk_scene *scene, size_t wall);

/* The same of a group, 1, 2, ... */
void rk_scene_group(const struct rk_scene *scene, size_t group, double displacement[2],
                    double velocity[2], double force[2]);
struct rk_wall_turn rk_scene_group_turn(const struct rk_scene *scene, size_t group);

/* Energies of the present state: translation, rotation, springs of the contacts, height above 0.
 * Grains of groups have none but that of their contacts. */
struct rk_energy {
    double kinetic, rotational, elastic, gravitational;
    double sheared; /* the part of elastic that tangential and rolling springs hold */
};
struct rk_energy rk_scene_energy(const struct rk_scene *scene);

/* Where energy came from and went since the clock started or, if that was later, since a grain was
 * added, held or let go, with spec.ledger; false without, and until the next step after what
 * changes forces between two steps. The residual, energy - start - gravity - walls - groups -
 * growth + damping + friction + rolling, is the error of the time step: it shrinks with dt^2
 * (engine/ledger.h), unless rk_scene_set_drive has made a wall jump. Friction and rolling include
 * what their springs hold at present. */
struct rk_ledger {
    double start, energy; /* kinetic, rotational and of normal springs, then and now */
    double gravity, walls, groups, growth; /* work done on the grains */
    double damping, friction, rolling;
    double residual;
    double
        input; /* start, and all work while it was above 0: what came in, even if it went again */
};
bool rk_scene_ledger(const struct rk_scene *scene, struct rk_ledger *out);
/* Of one wall: the work it has done on the grains, what its contacts have taken; 0 without. */
double rk_scene_wall_work(const struct rk_scene *scene, size_t wall);
double rk_scene_wall_dissipation(const struct rk_scene *scene, size_t wall);
double rk_scene_group_work(const struct rk_scene *scene, size_t group);
double rk_scene_group_dissipation(const struct rk_scene *scene, size_t group);

/* The largest value of two kinds of trouble at present, for `check`s and for choosing limits. */
struct rk_strain {
    double overlap; /* largest overlap / smaller radius */
    double travel;  /* largest |v| dt / radius */
};
struct rk_strain rk_scene_strain(const struct rk_scene *scene);

/* ---- Keeping and resuming ---------------------------------------------------------------- */

/* The state as a block of bytes: everything that the field tables declare. Unpack into a scene
 * with the same spec, walls, groups and growths and no grains; the run goes on with the same bytes.
 * Contacts are there at once with what they remember. Until the next step their other forces are 0:
 * normal forces, but those of pairs with an integrator that remembers them; tangential forces of
 * pairs without springs; the forces on walls and groups.
 * RK_EFORMAT when the block is not such a state (it may come from a damaged file: every size and
 * index is checked); the scene must then be freed. */
size_t rk_scene_packed_size(const struct rk_scene *scene);
void rk_scene_pack(const struct rk_scene *scene, void *block);
enum rk_status rk_scene_unpack(struct rk_scene *scene, const void *block, size_t size,
                               struct rk_error *err);

/* ---- Measuring --------------------------------------------------------------------------- */

enum rk_phase {
    RK_PHASE_MOVE,       /* predict and correct */
    RK_PHASE_NEIGHBOURS, /* renewing the list */
    RK_PHASE_CLOSE,      /* picking the close ones among the listed pairs */
    RK_PHASE_PUSH,       /* which of them touch, their forces, summed into the grains */
    RK_PHASE_WALLS,
    RK_PHASE_COUNT
};
const char *rk_phase_name(enum rk_phase phase);

struct rk_profile {
    uint64_t ticks[RK_PHASE_COUNT]; /* of the caller's clock, 0 without one */
    uint64_t rebuilds;              /* of the neighbour list */
    uint64_t pairs;                 /* neighbour pairs looked at, summed over steps */
    uint64_t picks;                 /* of close pairs among the listed ones */
    uint64_t close;                 /* close pairs, summed over steps */
    uint64_t contacts;              /* touching pairs, summed over steps */
};
/* A clock to time the phases with; NULL (the default) for none. With one, grains are always moved
 * in a pass of their own, so that it can be told from the forces: that takes longer. */
void rk_scene_set_clock(struct rk_scene *scene, uint64_t (*now)(void));
struct rk_profile rk_scene_profile(const struct rk_scene *scene);
size_t rk_scene_memory(const struct rk_scene *scene); /* bytes held */

/* ---- Probes ------------------------------------------------------------------------------ */

/* What a case tells the probes about its scene. */
struct rk_focus {
    uint32_t grain; /* the grain of interest, the intruder */
    size_t wall;    /* the wall heights are measured from, the plate */
};

struct rk_probe_column {
    const char *name, *unit, *doc;
};

/* A probe turns a scene into one row of numbers; it has no state and cannot change anything. */
struct rk_probe {
    struct rk_piece piece;
    const struct rk_probe_column *columns;
    size_t count;
    void (*sample)(const struct rk_scene *scene, const struct rk_focus *focus, double *row);
};

#endif
