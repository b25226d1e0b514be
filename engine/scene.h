/* The inside of a scene. Private to engine/.
 *
 * Grains are structures of arrays in an order that keeps neighbours in space near in memory. The
 * order is renewed at fixed step numbers, never when a list happens to be rebuilt: sums run in
 * this order, so it is part of the trajectory and must not depend on a skin or a method.
 */
#ifndef RK_ENGINE_SCENE_H
#define RK_ENGINE_SCENE_H

#include "engine/engine.h"
#include "engine/primitives.h"

/* Loops over arrays take whole vectors: arrays are padded to blocks of this many, a multiple of
 * every vector width, and what lies behind their last entry is read but never used. */
enum { RK_BLOCK = 8 };

/* What forces need of a grain, and what they add up to, are rows of half a cache line: x, y, vx,
 * vy; fx, fy, torque and one unused. Where nothing rotates the sums are pairs: fx, fy. */
enum { RK_ROW_WIDTH = 4, RK_PAIR_WIDTH = 2 };

/* What a contact has: the tangential force where there is friction, the rolling moment where there
 * is rolling resistance, the normal force. It remembers while it lives those that its law needs:
 * springs the first, rolling springs the second, an implicit integrator the third. */
enum { RK_HISTORY_FT, RK_HISTORY_MOMENT, RK_HISTORY_FN, RK_HISTORIES };

/* What a scene may have or not have; state that belongs to it is there or not. */
enum rk_need {
    RK_ALWAYS,
    RK_IF_ROTATES,      /* there is friction */
    RK_IF_REMEMBERS,    /* contacts have a history */
    RK_IF_SPRINGS,      /* friction remembers */
    RK_IF_ROLLS,        /* there is rolling resistance */
    RK_IF_MIXED,        /* there are several materials */
    RK_IF_LEDGER,       /* energies are accounted for */
    RK_IF_LIDS,         /* a wall answers to the grains */
    RK_IF_IMPLICIT,     /* the integrator remembers normal forces */
    RK_IF_DERIVED,      /* the integrator keeps third and fourth derivatives */
    RK_IF_DERIVED_TURN, /* and something rotates */
    RK_IF_GROUPS,       /* some grains are carried by drives */
    RK_IF_GROUPS_TURN,  /* and something rotates */
    RK_IF_GROWS,        /* radii change */
    RK_NEEDS
};

struct rk_grains {
    size_t count, capacity;
    double *x, *y, *vx, *vy, *ax, *ay;
    double *angle, *omega, *alpha; /* NULL where nothing rotates; alpha = angular acceleration */
    double *radius, *mass, *inverse_mass; /* inverse_mass is 0 for a held grain */
    double *inverse_inertia;              /* likewise; NULL where nothing rotates */
    double *jx, *jy, *sx, *sy; /* third and fourth derivatives of the place; NULL if not kept */
    double *jerk, *snap;       /* of the angle */
    uint32_t *tag;
    uint32_t *material; /* NULL where there is one material only */
    uint32_t *group;    /* 0, or 1 + the number of the group that carries it; NULL without groups */
    uint32_t *growth;   /* 0, or 1 + the number of its growth; NULL where none grows */
    double *density;    /* m = density R^2 (disc) or R^3 (sphere); likewise */
    double *home_x, *home_y, *home_angle; /* where the group's frame has it */
    double *force;                        /* [capacity][rk_force_width()], scratch of a step */
    double *motion; /* [capacity][RK_ROW_WIDTH], what the forces are evaluated with: while a step is
                     * under way places and velocities are here, and x, y, vx, vy may be old */
    double *ease;   /* how easily its contacts move a grain, scratch of an implicit step; or NULL */
    double *spread; /* [capacity][RK_ROW_WIDTH], scratch for that */
};

/* x, y, vx, vy of grain i, as the forces have them. */
static inline double *rk_grain_motion(const struct rk_grains *grains, size_t i) {
    return grains->motion + RK_ROW_WIDTH * i;
}

/* Of a row of grains->force. */
static inline size_t rk_force_width(const struct rk_grains *grains) {
    return grains->omega ? RK_ROW_WIDTH : RK_PAIR_WIDTH;
}

/* Neighbour pairs in the order of (first, second), first < second. */
struct rk_pairs {
    size_t count, capacity;
    uint32_t *first, *second;
    double *shift; /* added to x[second] - x[first] to reach the nearest image; NULL if open */
    double *reach; /* R_first + R_second */
    double *history[RK_HISTORIES]; /* of pairs that are not close, to which it returns; or NULL */
};

/* The close ones among a thread's pairs, in the same order, those of earlier threads whose second
 * grain is its own before them ("ghosts": both threads work them out, each for its own grain).
 * engine/close.h */
struct rk_close {
    size_t ghosts;            /* from 0 on, and filled up to `own` */
    size_t own;               /* from here to `end`; a multiple of RK_BLOCK */
    size_t crossing;          /* from here on the second grain may be another thread's; likewise */
    size_t end;               /* filled up behind that */
    size_t last;              /* the rows of the thread's grains are before this */
    size_t touching;          /* its own ones of the last step */
    uint32_t *first, *second; /* where their rows begin: RK_ROW_WIDTH times the grain */
    uint32_t *pair;           /* NULL where nothing is remembered */
    double *shift, *reach;
    double *radius_first, *radius_second; /* NULL where no law needs them */
    double *history[RK_HISTORIES]; /* of the last step, 0 if not touching; what contacts do not
                                    * remember is stale from a pick to the next push */
};

/* The touching ones of the last step in the same order, for whoever wants to look. */
struct rk_touching {
    size_t count;
    uint32_t *first, *second;
    double *dx, *dy, *d2; /* from first to second */
    double *history[RK_HISTORIES];
};

/* Bounds of the displacements of all grains since the neighbour list was built: the sums of the
 * bounds of each step's moves, which need no old positions. */
struct rk_bounds {
    double low[2], high[2];
};

/* Widen bounds to hold others as well. */
static inline void rk_bounds_join(struct rk_bounds *all, const struct rk_bounds *part) {
    for (int k = 0; k < 2; k++) {
        all->low[k] = part->low[k] < all->low[k] ? part->low[k] : all->low[k];
        all->high[k] = part->high[k] > all->high[k] ? part->high[k] : all->high[k];
    }
}

/* Partners of grains as a thread finds them, row after row. */
struct rk_found {
    uint32_t *second;
    size_t count, capacity;
    bool failed; /* no memory */
};

/* What one thread does: rows of the pair list, which are grains, and their pairs and contacts. */
struct rk_share {
    struct rk_found found; /* scratch of a build */
    size_t begin, end;     /* grains; begin is a multiple of the vector width */
    size_t pair_begin, pair_end;
    size_t ghost_begin, ghost_end; /* in scene->ghosts: pairs of earlier threads */
    struct rk_close close;         /* a stretch of the scene's arrays */
    struct rk_bounds moved;
};

/* Cells over the box, by rows. */
struct rk_grid {
    double x0, y0, inverse_w, inverse_h;
    uint32_t columns, rows;
    bool periodic; /* the last column is next to the first */
};

struct rk_neighbours {
    bool valid;
    struct rk_bounds moved; /* since then */
    bool close_valid;
    struct rk_bounds crept; /* since the close ones were picked */
    double grown;           /* since the build, two of the grains that grow most together */
    bool swollen;           /* some radius has changed since the close ones were picked */
    double cell;            /* side of a cell */
    double bulk_radius;     /* grains up to this fit the cells; larger ones search further */
    double largest;         /* the largest sum of two radii, of grains grown up */
    double widest;          /* the largest radius, likewise */
    double smallest;        /* the smallest radius that a grain may come to */
    struct rk_grid grid;    /* scratch of a build, as all until row_start */
    uint32_t *cell_start, *cell_of, *in_cell; /* grains by cells */
    size_t cell_capacity;                     /* of cell_start and large_start */
    uint32_t *large_start, *large_near;       /* for each cell the large grains that reach it */
    size_t large_capacity;
    uint32_t *row_start; /* [capacity + 1] first pair of each grain */
};

/* Where a wall is: a displacement, and an angle about its pivot. */
struct rk_pose {
    double shift[2], velocity[2];
    double angle, turn; /* turn = angular velocity */
    double cosine, sine;
};

/* What a wall and a group of grains have in common: engine/movers.h. */
struct rk_mover {
    struct rk_drive_spec drive;
    double pivot[2];
    struct rk_pose pose;
    double force[2]; /* of the grains on it */
};

/* What may touch a wall before its list is renewed, in the order of (primitive, grain). */
struct rk_near {
    size_t count, capacity;
    uint32_t *primitive, *grain;
    double *history[RK_HISTORIES]; /* of the last step, 0 if not touching */
    uint8_t *before, *now;         /* touching in the last step, in this one */
    bool valid;
    struct rk_bounds moved; /* of the neighbours when it was built, and the wall's pose */
    double grown;           /* of the neighbours, likewise */
    struct rk_pose pose;
    double at; /* of a line: normal . at */
};

/* The primitives of a wall by where they are along x (0) or y (1) in its frame. */
struct rk_wall_index {
    int axis;
    double *middle; /* ascending: coordinate of the primitive's middle */
    uint32_t *primitive;
    double bound;         /* the largest of the primitives' */
    double low_x, high_x; /* all of the wall lies between */
};

struct rk_wall {
    struct rk_wall_index index; /* empty for a line */
    struct rk_wall_spec spec;   /* without the vertices; drive and pivot are the mover's */
    struct rk_mover mover;
    struct rk_primitive *primitives;
    size_t primitive_count;
    bool line;               /* its one primitive is a line */
    bool ring;               /* the last primitive is joined to the first */
    double extent;           /* the largest distance from the pivot */
    double at[2], normal[2]; /* of a line, at present */
    struct rk_near near;
};

/* Grains that a drive carries: engine/groups.h. */
struct rk_group {
    struct rk_mover mover;
    size_t material;
    double torque; /* of the grains on it, about the pivot */
};

/* Wall contacts of the last step, by wall, primitive, grain. Capacities are whole vectors. */
struct rk_wall_touching {
    size_t count, capacity;
    uint32_t *wall, *primitive, *grain, *material;
    uint32_t *entry;           /* in the wall's near list */
    double *nx, *ny, *overlap; /* normal from the grain to the wall */
    double *vx, *vy, *omega;   /* velocity of the wall where it is touched, and its spin */
    double *rough;             /* 1, or 0 at a smooth wall */
    double *fn;
    size_t histories;
    double *history[RK_HISTORIES];
    double *force; /* [capacity][RK_ROW_WIDTH]: on the wall fx, fy; torque on the grain */
};

/* The energy ledger's rows, engine/ledger.h. */
struct rk_ledger_rows {
    double *work, *damping, *friction, *rolling;
};

struct rk_ledger_state {
    size_t count; /* one for each mover there may be, one for pairs and gravity, one for growth */
    struct rk_ledger_rows sums, rates;
    double *gains; /* sums of the work's rates where they are above 0 */
    double *start; /* [0]: kinetic, rotational and elastic energy at the beginning; [1]: 1 once it
                    * has been taken */
};

/* The lids among the movers: an entry for each mover there may be, none without lids. */
struct rk_lids {
    size_t count;
    double *position, *velocity, *acceleration; /* along the drive's direction */
};

struct rk_kernel;

struct rk_scene {
    struct rk_scene_spec spec;
    const struct rk_kernel *kernel;
    bool has[RK_NEEDS];
    struct rk_material materials[RK_MATERIALS_MAX]; /* material 0 is spec.contact's */
    size_t material_count;
    bool ready;     /* sizes that depend on the radii are known, tags are indexed */
    bool under_way; /* a step has been predicted and not yet corrected: see grains.motion */
    uint64_t steps;
    uint64_t primed;    /* 1 once accelerations belong to the positions */
    uint32_t *index_of; /* [tag] the grain's place in the order; NULL before the first step */
    struct rk_grains grains;
    struct rk_pairs pairs;
    struct rk_close close; /* the arrays of all shares */
    size_t close_capacity;
    uint32_t *ghosts;            /* pairs whose second grain is another thread's, by that thread */
    struct rk_touching touching; /* whole between calls; within a step, the shares have it */
    struct rk_share *shares;
    size_t share_count;
    bool scattered; /* the contacts lie with the shares, not in touching */
    struct rk_neighbours neighbours;
    struct rk_wall *walls;
    size_t wall_count;
    struct rk_wall_touching wall_touching;
    struct rk_group *groups; /* NULL without */
    size_t group_count;
    uint32_t *carried; /* places in the order of all grains of groups, ascending */
    size_t carried_count;
    struct rk_growth_spec growths[RK_GROWTHS_MAX];
    size_t growth_count;
    uint32_t *growing; /* places in the order of all grains that grow, ascending */
    size_t growing_count;
    double *swelling; /* [grain] scratch: rate of the radius, of those that grow */
    uint8_t *late;    /* [block of RK_BLOCK grains] 1 while it waits: engine/sweep.h */
    struct rk_lids lids;
    struct rk_ledger_state ledger;
    double gravity[2]; /* of the present moment */
    uint64_t (*now)(void);
    struct rk_profile profile;
};

/* A grain's place in the order, SIZE_MAX if there is none of that tag. */
size_t rk_scene_index(const struct rk_scene *scene, uint32_t tag);

/* Work out what depends on the radii; before the first step and after unpacking. */
enum rk_status rk_scene_get_ready(struct rk_scene *scene, struct rk_error *err);

/* Must contacts remember this, as one of RK_HISTORY_...? Has a contact got it? */
bool rk_scene_keeps(const struct rk_scene *scene, int history);
bool rk_scene_knows(const struct rk_scene *scene, int history);

/* The forces of the present positions and velocities in grains->force, as after a step of dt; dt
 * below 0 goes back in time. */
enum rk_status rk_scene_add_forces(struct rk_scene *scene, double dt, struct rk_error *err);

/* Back to the state that this very scene packed, to look at another moment and return. */
void rk_scene_rewind(struct rk_scene *scene, const void *block);

/* Renew index_of after the order has changed. */
void rk_scene_index_tags(struct rk_scene *scene);

#endif
