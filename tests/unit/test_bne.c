/* The Brazil-nut box: an intruder of a material of its own, and keys that stay what they were. */
#include "cases/bne/bne.h"
#include "ensemble/study.h"
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A soft bed on a plate, settled well. */
static struct rk_bne quiet_bed(double stiffness, double mu) {
    struct rk_bne bne;
    rk_param_defaults(rk_case_bne.params, &bne);
    bne.grains.count = 60;
    bne.box.width = 8;
    bne.intruder = (struct rk_bne_intruder){3, 1, stiffness, mu};
    bne.contact.kn = 200;
    bne.contact.kt = 150;
    bne.settle.kinetic = 1e-13;
    bne.settle.step = 0.04;
    return bne;
}

static struct rk_scene *prepared(const struct rk_bne *bne) {
    struct rk_scene *scene = NULL;
    struct rk_preparation report;
    struct rk_error err = RK_NO_ERROR;
    struct rk_stream stream = rk_stream_of(5, 0, 0, RK_FOR_TESTS, 0);
    if (rk_case_bne.check(bne, &err) ||
        rk_case_prepare(&rk_case_bne, bne, stream, NULL, &scene, &report, &err)) {
        fail_msg("%s", err.message);
    }
    return scene;
}

/* At rest the force of a contact is its spring's: k delta, with k the harmonic mean of the two
 * stiffnesses. What moves still adds at most the dashpot's gamma times the relative velocity of two
 * bodies that have all the kinetic energy there is; gammas mix to less than twice the grains'. */
static void contacts_have_the_mean_stiffness(void **state) {
    (void)state;
    const double stiffness = 4, series = 2 * stiffness / (1 + stiffness);
    struct rk_bne bne = quiet_bed(stiffness, 0.25);
    struct rk_scene *scene = prepared(&bne);
    struct rk_energy energy = rk_scene_energy(scene);
    const struct rk_scene_spec *spec = rk_scene_spec(scene);
    double speed = sqrt(2 * (energy.kinetic + energy.rotational) / spec->smallest);
    size_t of_intruder = 0, of_grains = 0;
    for (size_t c = 0; c < rk_scene_contacts(scene); c++) {
        struct rk_contact contact;
        rk_scene_contact(scene, c, &contact);
        bool intruder = contact.first == 0 || (!contact.wall && contact.second == 0);
        double k = bne.contact.kn * (intruder ? series : 1);
        assert_true(fabs(contact.fn - k * contact.overlap) <=
                    4 * spec->gamma * speed + 1e-9 * bne.contact.kn);
        /* Only a force that says more than this bound can tell one stiffness from the other. */
        bool telling = contact.fn * (series - 1) > 10 * 4 * spec->gamma * speed;
        of_intruder += intruder && telling;
        of_grains += !intruder && telling;
        /* Coulomb's cap: mu sqrt(ratio) at the intruder. */
        double mu = bne.contact.mu * (intruder ? sqrt(bne.intruder.mu) : 1);
        assert_true(fabs(contact.ft) <= mu * contact.fn * (1 + 1e-12));
    }
    assert_true(of_intruder >= 2 && of_grains >= 20);
    rk_scene_free(scene);
}

static double stable_step(double stiffness) {
    struct rk_bne bne = quiet_bed(stiffness, 1);
    return rk_case_bne.schedule(&bne).stable_dt;
}

static void a_stiffer_intruder_asks_for_shorter_steps(void **state) {
    (void)state;
    assert_true(stable_step(0.01) == stable_step(1));
    assert_true(stable_step(4) < stable_step(1));
    /* In series with a grain's spring no stiffness comes to more than twice that. */
    struct rk_bne twice = quiet_bed(1, 1);
    twice.contact.kn *= 2;
    twice.contact.kt *= 2;
    twice.contact.damping *= sqrt(2); /* gamma: twice, too */
    double least = rk_case_bne.schedule(&twice).stable_dt;
    assert_true(stable_step(1e6) >= least && stable_step(1e6) < 1.01 * least);
}

/* The same intruder from a packed state: `empty` has its material as well. */
static void its_material_survives_packing(void **state) {
    (void)state;
    struct rk_bne bne = quiet_bed(4, 0.25);
    struct rk_scene *scene = prepared(&bne), *again = NULL;
    struct rk_error err = RK_NO_ERROR;
    size_t size;
    void *block = kit_packed(scene, &size);
    assert_int_equal(rk_case_empty(&rk_case_bne, &bne, &again, &err), RK_OK);
    assert_int_equal(rk_scene_unpack(again, block, size, &err), RK_OK);
    assert_int_equal(kit_grain(again, 0).material, 1);
    assert_int_equal(kit_grain(again, 1).material, 0);
    kit_step(scene, 500);
    kit_step(again, 500);
    kit_assert_same(scene, again);
    rk_scene_free(scene);
    rk_scene_free(again);
    free(block);
}

/* The key of the random numbers of a study of `line`. */
static uint64_t key_of(const char *line) {
    struct rk_study *study;
    struct rk_error err = RK_NO_ERROR;
    char text[200];
    snprintf(text, sizeof text, "study: a\ncase: bne\nbase:\n  %s\n", line);
    if (rk_study_parse("text", text, strlen(text), &study, &err)) {
        fail_msg("%s", err.message);
    }
    uint64_t key = study->points[0].key;
    rk_study_free(study);
    return key;
}

/* A parameter that is added must not give older studies other beds: this key is that of the
 * defaults before the intruder had a material. */
static void added_parameters_change_no_key(void **state) {
    (void)state;
    const uint64_t before = 0x165846bb4af73318u;
    assert_true(key_of("grains.count: 2500") == before);
    assert_true(key_of("intruder: {stiffness: 1, mu: 1}") == before);
    assert_true(key_of("run.threads: 2") == before);
    assert_true(key_of("intruder.mu: 0.5") != before);
    assert_true(key_of("intruder.stiffness: 0.5") != before);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(contacts_have_the_mean_stiffness),
        cmocka_unit_test(a_stiffer_intruder_asks_for_shorter_steps),
        cmocka_unit_test(its_material_survives_packing),
        cmocka_unit_test(added_parameters_change_no_key),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
