/* Files that people write: studies and tables. */
#include "ensemble/input/table.h"
#include "ensemble/study.h"
#include "ensemble/study/yaml.h"
#include "tests/fuzz/targets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void *copy(const char *text, size_t *size) {
    *size = strlen(text);
    char *block = malloc(*size + 1);
    fuzz_check(block != NULL, "memory");
    memcpy(block, text, *size + 1);
    return block;
}

/* ---- Studies -----------------------------------------------------------------------------------
 */

static void *study_seed(size_t k, size_t *size) {
    static const char *const texts[] = {
        "study: quickstart\ncase: bne\nseed: 18446744073709551615\nreplicas: 3\nbase:\n"
        "  grains.count: 400\n  contact: {kn: 1e3, mu: 0.3}   # nested\n"
        "  accuracy.integrator: verlet-implicit\npoints:\n  - name: walls\n    box.sides: walls\n"
        "  - name: pbc\n    box: {sides: periodic, width: 28}\nanalyses:\n  - rise: {from: 10}\n"
        "  - ldf\n",
        "study: \"quo\\u0074ed\"\ncase: 'bne'\nbase: {contact.law: viscoelastic}\n"
        "points: [{name: a}, {name: b, drive.phase: .5}]\nretry: {step: 0.5, times: 2}\n"};
    return k < sizeof texts / sizeof *texts ? copy(texts[k], size) : NULL;
}

static enum rk_status study_attempt(const void *bytes, size_t size, struct rk_error *err) {
    struct rk_study *study = NULL;
    struct rk_plan *plan = NULL;
    struct rk_yaml *tree = NULL;
    enum rk_status parsed = rk_yaml_parse("fuzz", bytes, size, &tree, err);
    rk_yaml_free(tree);
    enum rk_status status = rk_study_load(fuzz_file(bytes, size), &study, err);
    fuzz_check(parsed == RK_OK || status != RK_OK, "a study from what is no YAML");
    if (status == RK_OK && study->replicas < 100) {
        status = rk_plan_create(study, &plan, err);
    }
    if (status == RK_OK) {
        char *text = rk_study_text(study);
        fuzz_check(text != NULL, "a study without text");
        struct rk_study *again = NULL;
        fuzz_check(rk_study_load(fuzz_file(text, strlen(text)), &again, NULL) == RK_OK,
                   "the text of a study does not load");
        rk_study_free(again);
        free(text);
    }
    rk_plan_free(plan);
    rk_study_free(study);
    return status;
}

const struct fuzz_target fuzz_study = {"study", "study files, YAML", study_seed, study_attempt,
                                       3000};

/* ---- Tables ------------------------------------------------------------------------------------
 */

static void *table_seed(size_t k, size_t *size) {
    static const char *const texts[] = {"# a comment\n\nt,height,run\n0,5,1\n1,6e-3,1\n0,-7,2\n",
                                        "\xef\xbb\xbf\"a; b\";\"run\"\r\n1;2\r\n3;4\r\n",
                                        "  0   5\n  1   6  \n", "0\t5\n1\t1e-300\n2\t-0\n"};
    return k < sizeof texts / sizeof *texts ? copy(texts[k], size) : NULL;
}

static enum rk_status table_attempt(const void *bytes, size_t size, struct rk_error *err) {
    static const struct rk_notice quiet = {NULL, NULL};
    static const struct rk_table_request requests[] = {{"2", NULL, 0, NULL},
                                                       {"height", "run", 0, &quiet},
                                                       {NULL, NULL, 0, NULL},
                                                       {"1", "2", 3, NULL}};
    const char *path = fuzz_file(bytes, size);
    enum rk_status status = RK_EINVALID;
    for (size_t r = 0; r < sizeof requests / sizeof *requests; r++) {
        struct rk_samples samples;
        enum rk_status one = rk_table_read(path, &requests[r], &samples, err);
        for (size_t i = 0; one == RK_OK && i < samples.replicas; i++) {
            fuzz_check(samples.lengths[i] <= samples.samples, "a series longer than the longest");
            for (size_t j = 0; j < samples.lengths[i]; j++) {
                fuzz_check(isfinite(samples.values[i * samples.samples + j]), "no number let in");
            }
        }
        status = one == RK_OK ? RK_OK : status;
        rk_samples_clear(&samples);
    }
    return status;
}

const struct fuzz_target fuzz_table = {"table", "columns of CSV files", table_seed, table_attempt,
                                       4000};
