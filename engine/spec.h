/* What a scene is made of, as a caller describes it: engine/engine.h has the units, and what a
 * scene does with it. Specs are plain values; what a pointer in one points to stays the caller's.
 */
#ifndef RK_ENGINE_SPEC_H
#define RK_ENGINE_SPEC_H

#include "base/error.h"
#include "base/param.h"
#include "base/piece.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- Pieces that can be chosen by name -------------------------------------------------- */

extern const struct rk_registry rk_law_registry;        /* linear, mass-damped, viscoelastic */
extern const struct rk_registry rk_friction_registry;   /* none, cundall-strack, haff-werner */
extern const struct rk_registry rk_rolling_registry;    /* none, spring */
extern const struct rk_registry rk_tension_registry;    /* cut, keep */
extern const struct rk_registry rk_cap_registry;        /* total, elastic */
extern const struct rk_registry rk_body_registry;       /* disc, sphere */
extern const struct rk_registry rk_gravity_registry;    /* none, constant, switched */
extern const struct rk_registry rk_drive_registry;      /* rest, sinusoid, ..., press */
extern const struct rk_registry rk_shape_registry;      /* line, segment, arc, polygon */
extern const struct rk_registry rk_integrator_registry; /* verlet, verlet-implicit, gear5 */
extern const struct rk_registry rk_neighbour_registry;  /* cells, verlet, all-pairs */
extern const struct rk_registry rk_kernel_registry;     /* portable, avx2, avx512 */
extern const struct rk_registry rk_probe_registry;      /* intruder, plate, bed, energy */

/* ---- What a scene is made of ------------------------------------------------------------- */

/* The contact of two bodies, or of a body and a wall. */
struct rk_contact_spec {
    const struct rk_piece *law;      /* out of rk_law_registry */
    const struct rk_piece *friction; /* out of rk_friction_registry */
    const struct rk_piece *rolling;  /* out of rk_rolling_registry */
    const struct rk_piece *tension;  /* out of rk_tension_registry */
    const struct rk_piece *cap;      /* out of rk_cap_registry */
    double kn;                       /* normal stiffness */
    double damping;                  /* gamma / (2 sqrt(kn m_min)), m_min the smallest mass */
    double restitution;              /* above 0: of two smallest grains, instead of damping */
    double kt;                       /* tangential stiffness, Cundall-Strack */
    double mu;                       /* coefficient of friction */
    double gamma_t;                  /* tangential damping, Haff-Werner */
    double mu_rolling;               /* coefficient of rolling resistance */
    double young, loss;              /* Y and A of the viscoelastic law */
};
enum { RK_CONTACT_PARAMS = 14 };
extern const struct rk_param rk_contact_params[RK_CONTACT_PARAMS];

/* The time step, how it is taken and how neighbours are found: what it costs and how exact it is.
 */
struct rk_accuracy_spec {
    double step; /* dt / sqrt(m/kn), at most, m of a mean grain; "zeta_t" of Martins 2021 */
    const struct rk_piece *integrator; /* out of rk_integrator_registry; NULL: verlet */
    const struct rk_piece *neighbour;  /* out of rk_neighbour_registry */
    double skin;                       /* extra reach of the neighbour list [d] */
};
enum { RK_ACCURACY_PARAMS = 4 };
extern const struct rk_param rk_accuracy_params[RK_ACCURACY_PARAMS];

/* When a run counts as nonsense. */
struct rk_health_spec {
    double overlap; /* largest overlap, as a share of the smaller radius */
    double travel;  /* largest move in one step, as a share of the grain's radius */
    uint64_t every; /* steps between two checks, at most; fewer while grains are fast */
};
enum { RK_HEALTH_PARAMS = 3 };
extern const struct rk_param rk_health_params[RK_HEALTH_PARAMS];

/* What pulls at all grains, and at servo lids. */
struct rk_gravity_spec {
    const struct rk_piece *kind; /* out of rk_gravity_registry; NULL: constant */
    double first[2];             /* constant and switched: acceleration */
    double then[2], when;        /* switched: the vector from time `when` on */
};

struct rk_scene_spec {
    size_t grains;               /* how many there will be at most, 0 to RK_GRAINS_MAX */
    size_t walls;                /* likewise, 0 to RK_WALLS_MAX */
    size_t groups;               /* of grains that are driven; likewise, 0 to RK_GROUPS_MAX */
    double period_x;             /* width of the periodic box [0, period_x), 0 for an open one */
    double gravity[2];           /* acceleration, while pull.kind is NULL */
    struct rk_gravity_spec pull; /* where that is not enough; in a scene always filled in */
    const struct rk_piece *body; /* out of rk_body_registry; NULL: disc */
    double dt;                   /* time step */
    double gamma;                /* normal damping constant, see rk_contact_gamma */
    double smallest;             /* smallest mass a grain may have */
    struct rk_contact_spec contact;
    struct rk_accuracy_spec accuracy;
    struct rk_health_spec health;
    bool ledger;    /* account for energies, see rk_scene_ledger */
    size_t threads; /* of this one scene; 0 and 1: the caller's own. The bytes are the same */
    const struct rk_piece
        *kernel; /* out of rk_kernel_registry; NULL: the fastest of this machine */
};

#define RK_GRAINS_MAX ((size_t)1 << 27)
#define RK_WALLS_MAX ((size_t)64)
#define RK_GROUPS_MAX ((size_t)64)

/* What bodies are made of, where they are not all of one material: the numbers of the laws. Two
 * materials mix as engine/contact.h says. Material 0 is always that of the contact spec. */
struct rk_material {
    double kn, gamma, kt, mu, gamma_t, mu_rolling, young, loss;
};
#define RK_MATERIALS_MAX ((size_t)8)

/* How radii change: at `rate`, above or below 0, as long as they are between two bounds. The mass
 * follows at constant density (as R^2 for discs, as R^3 for spheres), the moment of inertia, too;
 * what is added has the velocity and spin of the grain, which do not change. Grains may be of
 * different growths or of none, free, held or of a group (engine/growth.h). */
struct rk_growth_spec {
    double rate;
    double smallest, largest;
};
#define RK_GROWTHS_MAX ((size_t)16)

/* A grain as it is added and as it is looked at. */
struct rk_grain {
    double x, y, vx, vy;
    double angle, omega; /* 0 and ignored where there is no friction */
    double radius, mass; /* moment of inertia as spec.body says */
    bool held;           /* nailed to its place: feels forces, does not move */
    size_t material;     /* 0, or what rk_scene_add_material gave */
    size_t growth;       /* 0: none; or what rk_scene_add_growth gave */
    size_t group;        /* 0: free; or what rk_scene_add_group gave, which moves it from then on */
};

/* How a wall or a group moves.
 * sinusoid: displacement amplitude sin(2 pi t/period + phase) along direction
 * constant: displacement speed t along direction
 * rotation: angle spin t about the pivot
 * servo:    mass a = load + mass gravity.direction + (force of the grains).direction - damping v
 * press:    on by `stride` along direction, over the next `every` steps, whenever the mean kinetic
 *           energy of a grain is below `threshold` at a step number divisible by `every`
 *
 * Servo and press are lids: they begin at displacement 0, and where they are is part of the state.
 * They keep it when the clock is restarted; all others go back to their beginning. */
struct rk_drive_spec {
    const struct rk_piece *kind; /* out of rk_drive_registry; NULL: rest */
    double amplitude;
    double period;
    double phase;               /* [rad] */
    double direction[2];        /* unit vector */
    double speed;               /* constant */
    double spin;                /* rotation [rad/time] */
    double mass, load, damping; /* servo */
    double stride, threshold;   /* press */
    uint64_t every;             /* press [steps] */
};

/* A wall: a shape, in place at displacement and angle 0, and how it moves.
 * line:     infinite through `point`; everything on the side its normal points to is free
 * segment:  between two vertices; touched on both sides and at its ends
 * polygon:  a chain of edges through the vertices, closed or not; both sides, too
 * arc:      of a circle, counter-clockwise between two angles; from inside and from outside
 * engine/primitives.h says what touches where. Walls with two sides are thin: a grain whose centre
 * gets to the other side stays there, noticed only by a wall that encloses. In a periodic box a
 * grain meets them with its nearest image; every edge and arc must be narrower than the box by a
 * large grain's diameter. */
struct rk_wall_spec {
    const struct rk_piece *shape; /* out of rk_shape_registry; NULL: line */
    double point[2];              /* of a line: a point of it */
    double normal[2];             /* of a line: unit vector into the free side */
    const double (*vertices)[2];  /* of a segment or polygon: read when the wall is added */
    size_t vertex_count;
    bool closed;              /* the last vertex is joined to the first */
    bool encloses;            /* a closed polygon or whole circle: grains belong inside it, and one
                               * whose centre gets out ends the run */
    double centre[2], radius; /* of an arc */
    double from, to;          /* angles, from < to <= from + 2 pi */
    double pivot[2];          /* it turns, and its torque is reported, about this point of it */
    bool friction;            /* false: this wall is smooth, whatever the contact says */
    size_t material;          /* 0, or what rk_scene_add_material gave */
    struct rk_drive_spec drive;
};

/* Grains that a drive carries, together or one alone: also a wall made of grains. A grain is added
 * to it where it is at displacement and angle 0; its velocity and `held` do not count, it is of the
 * group's material. Forces act on such grains but do not move them. They do not interact with each
 * other, with grains of another group, nor with walls, and count as wall in energies. */
struct rk_group_spec {
    struct rk_drive_spec drive;
    double pivot[2]; /* it turns, and its torque is reported, about this point of it */
    bool friction;   /* false: its grains are smooth (needs room for one material more) */
    size_t material; /* 0, or what rk_scene_add_material gave */
};

/* Do the parts of a contact fit each other? RK_EINVALID with err->subject naming one. */
enum rk_status rk_contact_check(const struct rk_contact_spec *contact, struct rk_error *err);

/* The material a contact spec describes. */
struct rk_material rk_contact_material(const struct rk_contact_spec *contact, double gamma);

/* gamma of a contact: damping * 2 sqrt(kn smallest), or what gives the restitution to two of the
 * smallest grains; for the mass-damped law divided by their reduced mass. */
double rk_contact_gamma(const struct rk_contact_spec *contact, double smallest);

/* The largest w0 dt for which an integrator (NULL: verlet) is stable on one contact of damping
 * zeta, x'' = -w0^2 x - 2 zeta w0 x', from the eigenvalues of its map; at most 2. */
double rk_integrator_limit(const struct rk_piece *integrator, double zeta);

/* The largest time step for which it is stable for a grain of mass `smallest` in a triangular
 * packing of its like (w^2 = 6 kn/m, damping likewise; with friction w^2 = 24 kt/m of turning;
 * engine/README.md, "Integrator"), for discs of one material. Measured limits of lattices are
 * 0 to 3 per cent above, and up to 5 per cent below where those of dashpots and of turning nearly
 * coincide (tests/physics/test_stability.c): stay below 80 per cent of it. A light grain that
 * touches more than six others may need a shorter one. */
double rk_stable_step(const struct rk_piece *integrator, const struct rk_contact_spec *contact,
                      double gamma, double smallest);

#endif
