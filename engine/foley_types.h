/* The particle types of Foley 2010, 0 to 9, as groups, drives and growths of this engine.
 *
 * His types are the cases of one function of his code ("Boundary Condition Code"); only type 0
 * obeys forces. His lengths and times are metres and seconds, his n is a particle's place in its
 * file.
 *
 *   0  free        obeys forces
 *   1  static      stays where it is
 *   2  swinging    x = 0.5 - 0.4 cos 10 t, y = 0.1
 *   3  turning     about (0.5, 0.5) with angular velocity 1
 *   4  wheel       x = 0.5 + 0.1 cos t + 0.4 cos(t + p), y likewise with sines, p = 2 pi n/128:
 *                  on a circle of radius 0.4 about (0.6, 0.5) that turns about (0.5, 0.5)
 *   5  vibrating   y = y0 + 0.02 sin 30 t
 *   6  staggered   y = 0.1 + 0.02 floor(n/2) + 0.02 sin 30 t: pairs, one above the other
 *   7  growing     its radius is 0.001 larger each step; stays where it is
 *   8  shrinking   its radius is 0.001 smaller each step; stays where it is
 *   9  press       0.001 down in each step that begins with a kinetic energy of all free
 *                  particles below 1e-6, rotation included
 *
 * What is otherwise here. His velocities of type 2 (sin t for sin 10 t), of type 4 (a sign) and his
 * places of type 5 (increments that depend on dt) contradict each other: the velocities follow from
 * the places of 2, 4 and 6, the places of 5 from its velocity. The mass of 7 and 8 follows the
 * radius, and radii have bounds. The press takes `every` steps for its 0.001
 * (engine/drive_press.c); his jump would put energy in that no account could name. The text
 * (sec. 2.6.1) numbers otherwise: its type 2 is type 5 here, its type 3 goes down steadily, drive
 * "constant". */
#ifndef RK_ENGINE_FOLEY_TYPES_H
#define RK_ENGINE_FOLEY_TYPES_H

#include "engine/engine.h"

struct rk_foley_type {
    struct rk_piece piece;
    bool free;                  /* obeys forces; all others are of a group */
    struct rk_drive_spec drive; /* threshold of a press: of all free grains together */
    double pivot[2];
    double growth; /* of the radius in a step */
    /* NULL, or where particle n begins (displacement and angle 0), whatever its file says. */
    void (*home)(size_t n, double at[2]);
};

/* In the order of their numbers. */
extern const struct rk_registry rk_foley_registry;

/* The type of a number, NULL if there is none. */
const struct rk_foley_type *rk_foley_type(size_t number);

/* What the types' numbers are not enough for. */
struct rk_foley_context {
    size_t free;              /* particles of type 0 */
    double smallest, largest; /* radii, for 7 and 8 */
    uint64_t every;           /* steps of a stroke of the press */
    size_t material;
};

/* Add the group and the growth that grains of a type need: their numbers, 0 for none, are for
 * struct rk_grain. All grains of a type may share them. RK_EINVALID: no such type, or whatever
 * rk_scene_add_group and rk_scene_add_growth refuse. */
enum rk_status rk_foley_add(struct rk_scene *scene, size_t number,
                            const struct rk_foley_context *context, size_t *group, size_t *growth,
                            struct rk_error *err);

#endif
