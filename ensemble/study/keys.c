/* What may stand in the outermost map of a study file. */
#include "ensemble/study.h"

static const struct rk_study_key
    study = {{"study", "its name, and that of its folder; needed"}, NULL, NULL},
    scene = {{"case", "which scene; needed"}, NULL, NULL},
    seed = {{"seed", "of all random numbers; 1 without it"}, NULL, NULL},
    replicas = {{"replicas", "runs of every point; the pilot where there is an `until`"},
                NULL,
                NULL},
    base = {{"base", "parameters of the case that all points share, dotted or nested"}, NULL, NULL},
    points = {{"points", "a list of {name: NAME, PARAMETER: VALUE, ...}; one point without it"},
              NULL,
              NULL},
    sweep = {{"sweep", "axes that multiply every point: a list of {PARAMETER: [VALUE, ...]}"},
             NULL,
             NULL},
    analyses = {{"analyses", "a list of analyses, each a name or {NAME: {PARAMETER: VALUE, ...}}"},
                NULL,
                NULL},
    until = {{"until",
              "replicas are added until an interval of an analysis of the study is as narrow "
              "as asked"},
             "{analysis: rise, quantity: rate, half_width: 0.001, max_replicas: 100}",
             &rk_until_params},
    retry = {{"retry", "runs that go numerically wrong are done again with smaller time steps"},
             "{step: 0.5, times: 1}",
             &rk_retry_params},
    keep = {{"keep",
             "of a finished run: `results`, or `checkpoint`: also its state, so that a longer "
             "run goes on from there"},
            "checkpoint",
            NULL},
    include = {{"include",
                "another study file, or a list of them, relative to this one; what is here "
                "overrides it"},
               "common.yaml",
               NULL};

static const struct rk_piece *const keys[] = {
    &study.piece, &scene.piece,    &seed.piece,  &replicas.piece, &base.piece, &points.piece,
    &sweep.piece, &analyses.piece, &until.piece, &retry.piece,    &keep.piece, &include.piece,
};

const struct rk_registry rk_study_key_registry = {"key", "what a study file may hold", keys,
                                                  sizeof keys / sizeof *keys};
