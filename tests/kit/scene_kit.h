/* Scenes for tests: ordinary numbers, from which a test changes what it is about.
 *
 * Whatever cannot be done fails the test with the engine's own sentence. Scenes are freed by the
 * test (rk_scene_free), blocks with free. Random grains come from fixed streams. */
#ifndef RK_TESTS_SCENE_KIT_H
#define RK_TESTS_SCENE_KIT_H

#include "engine/engine.h"

/* The mean grain of the engine's units. */
#define KIT_RADIUS 0.5
#define KIT_MASS 0.25

/* ---- A spec ----------------------------------------------------------------------------- */

/* The piece of that name; there must be one. */
const struct rk_piece *kit_piece(const struct rk_registry *registry, const char *name);

/* kn = 1000, kt = 750, mu = 0.5 and constants for every other law; linear, Cundall and Strack's
 * friction, no rolling resistance, tension cut; no gravity, no damping; dt = 1e-4, a skin of 0.2;
 * a check of health every 1000 steps that lets nearly everything pass. */
struct rk_scene_spec kit_spec(size_t grains, size_t walls);

/* gamma as spec->contact asks for it, and dt at a share of the largest stable one. */
void kit_complete(struct rk_scene_spec *spec, double share);

struct rk_scene *kit_scene(const struct rk_scene_spec *spec);

/* ---- Walls and grains ------------------------------------------------------------------- */

void kit_add_wall(struct rk_scene *scene, const struct rk_wall_spec *wall);

/* A rough line through (x, y), free on the side of its normal. */
void kit_add_line(struct rk_scene *scene, double x, double y, double nx, double ny);

/* Rough floor y = 0 and sides x = 0 and x = width: walls 0, 1 and 2. */
void kit_add_box(struct rk_scene *scene, double width);

struct rk_grain kit_disc(double x, double y, double vx, double vy);
void kit_add(struct rk_scene *scene, struct rk_grain grain);

/* Grains on a lattice, row by row from (x, y): square, or triangular with every other row shifted
 * by half a spacing. One row is a chain; a wide lattice with speed is a gas. */
struct kit_lattice {
    size_t columns;
    double spacing, x, y;
    bool triangular;
    double spread;    /* radii uniform within +-spread of the mean grain's */
    double speed;     /* velocity components and omega R uniform within +-speed */
    size_t materials; /* grains take turns in materials 0 .. materials - 1; 0 and 1: all of 0 */
};
struct rk_grain kit_lattice_grain(const struct kit_lattice *lattice, size_t i);
void kit_add_lattice(struct rk_scene *scene, const struct kit_lattice *lattice, size_t count);

/* ---- Running and looking ---------------------------------------------------------------- */

void kit_step(struct rk_scene *scene, uint64_t steps);
void kit_run(struct rk_scene *scene, double time); /* to the nearest step */

struct rk_grain kit_grain(const struct rk_scene *scene, uint32_t tag);

/* Every number of the state is a number. */
void kit_assert_finite(const struct rk_scene *scene);

/* The largest net force on a free grain as a share of what acts on it: its weight and the forces of
 * its contacts as the last step had them, |sum f + m g|/(|m g| + sum |f|). 0 is equilibrium. A
 * grain without weight and contacts counts as balanced. */
double kit_imbalance(const struct rk_scene *scene);

/* Steps until twice in a row, a `stretch` of time apart, no grain's imbalance is above `share`.
 * After each stretch a tenth of all velocities is taken out, and all when motion has become less:
 * near a minimum of the energy therefore, which suits stiff and soft modes alike. However long a
 * heap rolls about before it has found its place, what is tested is where it rests; fails after
 * 2000. */
void kit_settle(struct rk_scene *scene, double stretch, double share);

/* Walls carry the weight of all grains against gravity, to `share` of it. */
void kit_assert_carried(const struct rk_scene *scene, double share);

/* ---- Bytes ------------------------------------------------------------------------------ */

void *kit_packed(const struct rk_scene *scene, size_t *size);

/* Both states have the same bytes; if not, says where they begin to differ. */
void kit_assert_same(const struct rk_scene *one, const struct rk_scene *other);
void kit_assert_same_block(const void *one, size_t one_size, const void *other, size_t other_size);

#endif
