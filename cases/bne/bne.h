/* The Brazil nut effect: one large grain at the bottom of a shaken bed (Martins 2021, ch. 5). */
#ifndef RK_CASES_BNE_BNE_H
#define RK_CASES_BNE_BNE_H

#include "cases/bed.h"
#include "cases/cases.h"

struct rk_bne_box {
    const struct rk_piece *sides; /* walls or periodic */
    double width;
    bool rough;  /* side walls have the grains' friction */
    double tilt; /* of gravity, degrees */
};

struct rk_bne_intruder {
    double diameter;
    double density, stiffness, mu; /* over those of the grains */
};
enum { RK_BNE_INTRUDER_PARAMS = 4 };
extern const struct rk_param rk_bne_intruder_params[RK_BNE_INTRUDER_PARAMS];

struct rk_bne_drive {
    double acceleration; /* Gamma = A (2 pi/T)^2/g */
    double period, phase;
};
enum { RK_BNE_DRIVE_PARAMS = 3 };
extern const struct rk_param rk_bne_drive_params[RK_BNE_DRIVE_PARAMS];

struct rk_bne {
    struct rk_grains_spec grains;
    struct rk_bne_intruder intruder;
    struct rk_bne_box box;
    struct rk_bne_drive drive;
    struct rk_contact_spec contact;
    struct rk_settle_spec settle;
    struct rk_accuracy_spec accuracy;
    struct rk_health_spec health;
    struct rk_run_spec run;
};

extern const struct rk_case rk_case_bne;

/* The two kinds of sides, for tests that fill a struct rk_bne by hand. */
extern const struct rk_piece rk_bne_sides_walls, rk_bne_sides_periodic;

#endif
