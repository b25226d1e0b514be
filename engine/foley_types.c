#include "engine/foley_types.h"

#include "engine/drives.h"

#include <gsl/gsl_math.h>
#include <gsl/gsl_sf_trig.h>

static void home_swinging(size_t n, double at[2]) {
    (void)n;
    at[0] = 0.5;
    at[1] = 0.1;
}

static void home_wheel(size_t n, double at[2]) {
    gsl_sf_result sine, cosine;
    double phase = 2 * M_PI * (double)(n % 128) / 128;
    gsl_sf_sin_e(phase, &sine);
    gsl_sf_cos_e(phase, &cosine);
    at[0] = 0.6 + 0.4 * cosine.val;
    at[1] = 0.5 + 0.4 * sine.val;
}

static void home_staggered(size_t n, double at[2]) {
    at[1] = 0.1 + 0.02 * (double)(n / 2);
}

static const struct rk_foley_type types[] = {
    {.piece = {"free", "obeys forces"}, .free = true},
    {.piece = {"static", "stays where it is"}},
    {.piece = {"swinging", "to and fro along x about (0.5, 0.1)"},
     .drive = {.kind = &rk_drive_sinusoid.piece,
               .amplitude = 0.4,
               .period = 2 * M_PI / 10,
               .phase = -M_PI / 2,
               .direction = {1, 0}},
     .home = home_swinging},
    {.piece = {"turning", "about (0.5, 0.5)"},
     .drive = {.kind = &rk_drive_rotation.piece, .spin = 1},
     .pivot = {0.5, 0.5}},
    {.piece = {"wheel", "of a circle that turns about a point off its centre"},
     .drive = {.kind = &rk_drive_rotation.piece, .spin = 1},
     .pivot = {0.5, 0.5},
     .home = home_wheel},
    {.piece = {"vibrating", "up and down about where it was"},
     .drive = {.kind = &rk_drive_sinusoid.piece,
               .amplitude = 0.02,
               .period = 2 * M_PI / 30,
               .direction = {0, 1}}},
    {.piece = {"staggered", "up and down, pairs one above the other"},
     .drive = {.kind = &rk_drive_sinusoid.piece,
               .amplitude = 0.02,
               .period = 2 * M_PI / 30,
               .direction = {0, 1}},
     .home = home_staggered},
    {.piece = {"growing", "stays where it is and grows"}, .growth = 0.001},
    {.piece = {"shrinking", "stays where it is and shrinks"}, .growth = -0.001},
    {.piece = {"press", "goes down whenever all is at rest"},
     .drive =
         {.kind = &rk_drive_press.piece, .stride = 0.001, .threshold = 1e-6, .direction = {0, -1}}},
};
enum { TYPES = sizeof types / sizeof *types };

static const struct rk_piece *const pieces[TYPES] = {
    &types[0].piece, &types[1].piece, &types[2].piece, &types[3].piece, &types[4].piece,
    &types[5].piece, &types[6].piece, &types[7].piece, &types[8].piece, &types[9].piece};
const struct rk_registry rk_foley_registry = {"particle type", "types 0 to 9 of Foley 2010", pieces,
                                              TYPES};

const struct rk_foley_type *rk_foley_type(size_t number) {
    return number < TYPES ? &types[number] : NULL;
}

/* The group of a type that is carried. */
static enum rk_status add_group(struct rk_scene *scene, const struct rk_foley_type *type,
                                const struct rk_foley_context *context, size_t *group,
                                struct rk_error *err) {
    struct rk_group_spec spec = {.drive = type->drive,
                                 .pivot = {type->pivot[0], type->pivot[1]},
                                 .friction = true,
                                 .material = context->material};
    if (spec.drive.kind == &rk_drive_press.piece) {
        spec.drive.every = context->every;
        spec.drive.threshold /= context->free > 0 ? (double)context->free : 1; /* of a grain */
    }
    return rk_scene_add_group(scene, &spec, group, err);
}

enum rk_status rk_foley_add(struct rk_scene *scene, size_t number,
                            const struct rk_foley_context *context, size_t *group, size_t *growth,
                            struct rk_error *err) {
    const struct rk_foley_type *type = rk_foley_type(number);
    enum rk_status status = RK_OK;
    *group = *growth = 0;
    if (!type) {
        return rk_fail(err, RK_EINVALID, "%zu is no particle type of Foley 2010, they are 0 to %d",
                       number, TYPES - 1);
    }
    if (type->growth != 0) {
        const struct rk_growth_spec spec = {type->growth / rk_scene_spec(scene)->dt,
                                            context->smallest, context->largest};
        status = rk_scene_add_growth(scene, &spec, growth, err);
    }
    return status || type->free ? status : add_group(scene, type, context, group, err);
}
