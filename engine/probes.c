#include "engine/engine.h"

static void intruder_sample(const struct rk_scene *scene, const struct rk_focus *focus,
                            double *row) {
    struct rk_grain grain = {0};
    double at[2] = {0, 0}, velocity[2] = {0, 0};
    rk_scene_grain(scene, focus->grain, &grain, NULL);
    rk_scene_wall(scene, focus->wall, at, velocity, NULL);
    row[0] = grain.y - at[1];
    row[1] = grain.vy - velocity[1];
    row[2] = grain.x;
    row[3] = grain.vx;
}

static const struct rk_probe_column intruder_columns[] = {
    {"height", "d", "height of the intruder's centre above the plate"},
    {"velocity", "sqrt(g d)", "vertical velocity relative to the plate"},
    {"x", "d", "horizontal position"},
    {"vx", "sqrt(g d)", "horizontal velocity"},
};
static const struct rk_probe intruder = {{"intruder", "the grain of interest, seen from the plate"},
                                         intruder_columns,
                                         4,
                                         intruder_sample};

static void energy_sample(const struct rk_scene *scene, const struct rk_focus *focus, double *row) {
    (void)focus;
    struct rk_energy energy = rk_scene_energy(scene);
    row[0] = energy.kinetic;
    row[1] = energy.rotational;
    row[2] = energy.elastic;
    row[3] = energy.gravitational;
}

static const struct rk_probe_column energy_columns[] = {
    {"kinetic", "m g d", "kinetic energy of translation of all grains"},
    {"rotational", "m g d", "kinetic energy of rotation"},
    {"elastic", "m g d", "energy of the springs of all contacts"},
    {"gravitational", "m g d", "potential energy, 0 at height 0"},
};
static const struct rk_probe energy = {
    {"energy", "energies of the whole scene"}, energy_columns, 4, energy_sample};

static void plate_sample(const struct rk_scene *scene, const struct rk_focus *focus, double *row) {
    double at[2] = {0, 0}, velocity[2] = {0, 0}, force[2] = {0, 0};
    rk_scene_wall(scene, focus->wall, at, velocity, force);
    row[0] = at[1];
    row[1] = velocity[1];
    row[2] = force[0];
    row[3] = force[1];
}

static const struct rk_probe_column plate_columns[] = {
    {"height", "d", "displacement of the plate"},
    {"velocity", "sqrt(g d)", "its velocity"},
    {"force_x", "m g", "horizontal force of the grains on it"},
    {"force_y", "m g", "vertical force of the grains on it"},
};
static const struct rk_probe plate = {
    {"plate", "the wall heights are measured from"}, plate_columns, 4, plate_sample};

static void bed_sample(const struct rk_scene *scene, const struct rk_focus *focus, double *row) {
    (void)focus;
    size_t contacts = rk_scene_contacts(scene), ends = 0;
    for (size_t c = 0; c < contacts; c++) {
        struct rk_contact contact;
        rk_scene_contact(scene, c, &contact);
        ends += contact.wall ? 1 : 2;
    }
    size_t grains = rk_scene_grains(scene);
    row[0] = grains ? (double)ends / (double)grains : 0;
    row[1] = rk_scene_strain(scene).overlap;
}

static const struct rk_probe_column bed_columns[] = {
    {"coordination", "", "mean number of contacts of a grain, walls included"},
    {"overlap", "R", "largest overlap, as a share of the smaller radius"},
};
static const struct rk_probe bed = {
    {"bed", "how dense and how strained the bed is"}, bed_columns, 2, bed_sample};

static const struct rk_piece *const probes[] = {&intruder.piece, &plate.piece, &bed.piece,
                                                &energy.piece};
const struct rk_registry rk_probe_registry = {"probe", "what a run is watched with", probes, 4};
