/* Oblique collisions of two discs, and of a disc with a wall, against an integration of the same
 * equations (engine/contact.h) that shares nothing with the engine: Runge-Kutta of fourth order
 * with the passages between sticking and sliding located, for every normal law and friction. */
#include "tests/kit/scene_kit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

/* One collision: `second` may be a wall, which is a partner of infinite size and mass. */
struct collision {
    const struct rk_piece *law, *friction, *tension, *cap;
    double kn, gamma, kt, mu, gamma_t, young, loss;
    double angle; /* between the relative velocity and the line of centres [rad] */
    double radius[2], mass[2], spin[2];
    bool wall;
};

/* What comes out: velocities and spins of the two. */
struct outcome {
    double v[2][2], omega[2];
};

/* ---- The independent integration ------------------------------------------------------------- */

enum { X1, Y1, X2, Y2, VX1, VY1, VX2, VY2, W1, W2, FT, STATES };
enum regime { FREE, STICKS, SLIDES };

struct motion {
    const struct collision *c;
    enum regime regime; /* of a Cundall-Strack contact */
    double sense;       /* sliding: the sign of ft */
};

static bool named(const struct rk_piece *piece, const char *name) {
    return strcmp(piece->name, name) == 0;
}

/* Normal force, slip and the directions at a state. */
struct forces {
    double n[2], overlap, fn, slip, arm[2];
    double capped; /* Coulomb's cap is mu times this, if it is above 0 */
};

static struct forces forces_at(const struct collision *c, const double *s) {
    struct forces f;
    double dx = s[X2] - s[X1], dy = s[Y2] - s[Y1], distance = hypot(dx, dy);
    double reach = c->radius[0] + c->radius[1], reduced = c->radius[0] * c->radius[1] / reach;
    double inertial = c->mass[0] * c->mass[1] / (c->mass[0] + c->mass[1]);
    f.n[0] = dx / distance;
    f.n[1] = dy / distance;
    f.overlap = reach - distance;
    f.arm[0] = c->radius[0] * distance / reach;
    f.arm[1] = c->radius[1] * distance / reach;
    if (c->wall) { /* the wall lies at y = 0, its normal from the grain is (0, -1) */
        f.n[0] = 0;
        f.n[1] = -1;
        f.overlap = c->radius[0] - s[Y1];
        f.arm[0] = reduced = c->radius[0];
        f.arm[1] = 0;
        inertial = c->mass[0];
    }
    double ux = s[VX2] - s[VX1], uy = s[VY2] - s[VY1], rate = -(ux * f.n[0] + uy * f.n[1]);
    double spring, dashpot;
    if (named(c->law, "linear")) {
        spring = c->kn * f.overlap;
        dashpot = c->gamma * rate;
    } else if (named(c->law, "mass-damped")) {
        spring = c->kn * f.overlap;
        dashpot = c->gamma * inertial * rate;
    } else {
        double depth = fmax(f.overlap, 0), root = c->young / 2 * sqrt(reduced * depth);
        spring = root * depth;
        dashpot = root * c->loss * rate;
    }
    f.fn = spring + dashpot;
    if (named(c->tension, "cut")) {
        f.fn = fmax(f.fn, 0);
    }
    f.capped = named(c->cap, "elastic") ? spring : f.fn;
    f.slip = uy * f.n[0] - ux * f.n[1] - f.arm[0] * s[W1] - f.arm[1] * s[W2];
    return f;
}

static double friction_at(const struct motion *m, const struct forces *f, const double *s) {
    const struct collision *c = m->c;
    if (named(c->friction, "cundall-strack")) {
        return m->regime == SLIDES ? m->sense * c->mu * fmax(f->capped, 0) : s[FT];
    }
    if (named(c->friction, "haff-werner")) {
        double cap = c->mu * fabs(f->capped);
        return fmax(-cap, fmin(cap, -c->gamma_t * f->slip));
    }
    return 0;
}

static void derive(const struct motion *m, const double *s, double *d) {
    const struct collision *c = m->c;
    struct forces f = forces_at(c, s);
    double ft = friction_at(m, &f, s);
    double fx = f.fn * f.n[0] - ft * f.n[1], fy = f.fn * f.n[1] + ft * f.n[0];
    memcpy(d, s + VX1, 4 * sizeof *d);
    d[VX1] = -fx / c->mass[0];
    d[VY1] = -fy / c->mass[0];
    d[VX2] = c->wall ? 0 : fx / c->mass[1];
    d[VY2] = c->wall ? 0 : fy / c->mass[1];
    d[W1] = -f.arm[0] * ft / (0.5 * c->mass[0] * c->radius[0] * c->radius[0]);
    d[W2] = c->wall ? 0 : -f.arm[1] * ft / (0.5 * c->mass[1] * c->radius[1] * c->radius[1]);
    d[FT] = m->regime == STICKS ? -c->kt * f.slip : 0;
}

static void advance(const struct motion *m, const double *from, double h, double *to) {
    static const double share[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    double slope[STATES] = {0}, at[STATES], sum[STATES] = {0};
    for (int stage = 0; stage < 4; stage++) {
        for (int k = 0; k < STATES; k++) {
            at[k] = from[k] + share[stage] * h * slope[k];
        }
        derive(m, at, slope);
        for (int k = 0; k < STATES; k++) {
            sum[k] += weight[stage] * slope[k];
        }
    }
    for (int k = 0; k < STATES; k++) {
        to[k] = from[k] + h / 6 * sum[k];
    }
}

/* Above 0 while the regime holds: the contact lives, the spring is below its cap, or the spring
 * would be stretched faster than the cap rises. */
static double regime_holds(const struct motion *m, const double *s) {
    const struct collision *c = m->c;
    struct forces f = forces_at(c, s);
    if (m->regime == STICKS) {
        return c->mu * fmax(f.capped, 0) - fabs(s[FT]);
    }
    double slope[STATES], ahead[STATES], behind[STATES];
    const double little = 1e-7;
    derive(m, s, slope);
    for (int k = 0; k < STATES; k++) {
        ahead[k] = s[k] + little * slope[k];
        behind[k] = s[k] - little * slope[k];
    }
    double rise =
        (fmax(forces_at(c, ahead).capped, 0) - fmax(forces_at(c, behind).capped, 0)) / little / 2;
    return m->sense * -c->kt * f.slip - c->mu * rise;
}

/* From one regime into the other, at a state where the present one has just ended. */
static void change_regime(struct motion *m, double *s) {
    struct forces f = forces_at(m->c, s);
    if (m->regime == STICKS) {
        m->sense = s[FT] > 0 ? 1 : -1;
        m->regime = SLIDES;
    } else {
        s[FT] = m->sense * m->c->mu * fmax(f.capped, 0);
        m->regime = STICKS;
    }
}

static void start(const struct collision *c, double *s) {
    memset(s, 0, STATES * sizeof *s);
    s[X2] = c->radius[0] + c->radius[1];
    s[VX1] = cos(c->angle);
    s[VY1] = sin(c->angle);
    if (c->wall) {
        s[X2] = 0;
        s[Y1] = c->radius[0];
        s[VX1] = sin(c->angle);
        s[VY1] = -cos(c->angle);
    }
    s[W1] = c->spin[0];
    s[W2] = c->wall ? 0 : c->spin[1];
}

/* Within the last step: up to the moment they part, where the force may jump to 0. */
static void part(const struct motion *m, double *s, double h) {
    double low = 0, high = h, next[STATES];
    for (int halving = 0; halving < 45; halving++) {
        double middle = 0.5 * (low + high);
        advance(m, s, middle, next);
        *(forces_at(m->c, next).overlap > 0 ? &low : &high) = middle;
    }
    advance(m, s, low, s);
}

/* Until the discs part, in steps of h: fourth order within a regime, its end found by bisection. */
static struct outcome reference(const struct collision *c, double h, double longest) {
    struct motion m = {.c = c, .regime = FREE};
    double s[STATES], next[STATES];
    start(c, s);
    if (named(c->friction, "cundall-strack")) {
        /* Does it slide from the first moment? Where fn begins at 0 its rate decides. */
        struct forces f = forces_at(c, s);
        m.sense = f.slip > 0 ? -1 : 1;
        m.regime = SLIDES;
        m.regime = f.capped > 0 || !(regime_holds(&m, s) > 0) ? STICKS : SLIDES;
    }
    for (double t = 0; t < longest; t += h) {
        advance(&m, s, h, next);
        double rest = h;
        for (int change = 0; m.regime != FREE && change < 4 && rest > 0; change++) {
            if (regime_holds(&m, next) >= 0) {
                break;
            }
            double low = 0, high = rest;
            for (int halving = 0; halving < 45; halving++) {
                double middle = 0.5 * (low + high);
                advance(&m, s, middle, next);
                *(regime_holds(&m, next) >= 0 ? &low : &high) = middle;
            }
            advance(&m, s, high, s);
            change_regime(&m, s);
            rest -= high;
            advance(&m, s, rest, next);
        }
        if (forces_at(c, next).overlap <= 0) {
            part(&m, s, h);
            break;
        }
        memcpy(s, next, sizeof s);
    }
    return (struct outcome){{{s[VX1], s[VY1]}, {s[VX2], s[VY2]}}, {s[W1], s[W2]}};
}

/* ---- The engine -------------------------------------------------------------------------------
 */

static struct outcome engine(const struct collision *c, double dt, double longest) {
    const double begin = 1e-13; /* an overlap that is there but does not matter */
    struct rk_scene_spec spec = kit_spec(2, 1);
    spec.dt = dt;
    spec.gamma = c->gamma;
    spec.smallest = fmin(c->mass[0], c->mass[1]);
    spec.contact.law = c->law;
    spec.contact.friction = c->friction;
    spec.contact.tension = c->tension;
    spec.contact.cap = c->cap;
    spec.contact.kn = c->kn;
    spec.contact.kt = c->kt;
    spec.contact.mu = c->mu;
    spec.contact.gamma_t = c->gamma_t;
    spec.contact.young = c->young;
    spec.contact.loss = c->loss;
    double s[STATES];
    start(c, s);
    struct rk_grain pair[2];
    for (int i = 0; i < 2; i++) {
        pair[i] = (struct rk_grain){.x = s[i ? X2 : X1] * (1 - begin),
                                    .y = s[i ? Y2 : Y1] * (1 - begin),
                                    .vx = s[i ? VX2 : VX1],
                                    .vy = s[i ? VY2 : VY1],
                                    .omega = s[i ? W2 : W1],
                                    .radius = c->radius[i],
                                    .mass = c->mass[i]};
    }
    struct rk_scene *scene = kit_scene(&spec);
    if (c->wall) {
        kit_add_line(scene, 0, 0, 0, 1);
    }
    for (int i = 0; i < (c->wall ? 1 : 2); i++) {
        kit_add(scene, pair[i]);
    }
    kit_step(scene, (uint64_t)ceil(longest / dt));
    assert_int_equal(rk_scene_contacts(scene), 0); /* they have parted */
    struct outcome o = {{{0}}, {0}};
    for (uint32_t i = 0; i < (c->wall ? 1 : 2); i++) {
        struct rk_grain g = kit_grain(scene, i);
        o.v[i][0] = g.vx;
        o.v[i][1] = g.vy;
        o.omega[i] = g.omega;
    }
    if (!rk_scene_rotates(scene)) { /* smooth discs have no spin to keep */
        o.omega[0] = c->spin[0];
        o.omega[1] = c->wall ? 0 : c->spin[1];
    }
    rk_scene_free(scene);
    return o;
}

/* The largest difference in velocities, spins counted as velocities of the rims. */
static double difference(const struct collision *c, const struct outcome *a,
                         const struct outcome *b) {
    double worst = 0;
    for (int i = 0; i < (c->wall ? 1 : 2); i++) {
        worst = fmax(worst, fabs(a->v[i][0] - b->v[i][0]));
        worst = fmax(worst, fabs(a->v[i][1] - b->v[i][1]));
        worst = fmax(worst, c->radius[i] * fabs(a->omega[i] - b->omega[i]));
    }
    return worst;
}

/* ---- The comparison ----------------------------------------------------------------------------
 */

/* A step and an end that suit the collision. The dashpots of three laws are set so that each takes
 * about as much. The stiffest that a grain may feel sets w0. */
static double frequency(const struct collision *c) {
    double inertial = c->mass[0] * c->mass[1] / (c->mass[0] + c->mass[1]);
    inertial = c->wall ? fmin(c->mass[0], inertial) : inertial;
    return sqrt(c->kn / inertial);
}

static struct collision typical(const struct rk_piece *law, const struct rk_piece *friction,
                                double degrees) {
    return (struct collision){
        .law = law,
        .friction = friction,
        .tension = kit_piece(&rk_tension_registry, "cut"),
        .cap = kit_piece(&rk_cap_registry, "total"),
        .kn = 1000,
        .gamma = named(law, "mass-damped") ? 40 : 5,
        .kt = 750,
        .mu = 0.5,
        .gamma_t = 5,
        .young = 2e4,
        .loss = 0.002,
        .angle = degrees * M_PI / 180,
        .radius = {0.5, 0.5},
        .mass = {0.25, 0.25},
    };
}

/* Errors of the engine in steps of w0 dt = 16e-3 and 1e-3, the worst over all angles.
 *
 * The order is the integrator's second, or 3/2 where a force begins like sqrt(t), as the
 * viscoelastic dashpot's does: steps 16 times finer leave 1/256 or 1/64. The phase of the end of a
 * contact with the step takes up to a factor of two of that. The error itself is some units
 * of (w0 dt)^2 or (w0 dt)^1.5 times the velocity of order one: below 1e-6 and 32e-6.
 *
 * Cundall and Strack's spring is stretched by vt dt with vt at the end of the step: a rectangle
 * rule of first order, 1/16. Its force is off by kt dt/2 times what vt has changed (2 at
 * most); over half a period, w0 t = pi, velocities are off by (kt/kn) pi = 2.4 times w0 dt at most.
 * Where the dashpot pulls, the force jumps at the end from gamma vn: seen up to one step late, it
 * changes velocities by gamma/m_eff vn dt, zeta = 0.22 and so below 0.45 w0 dt: first order again,
 * but with a phase that decides how much of it shows. */
static void compare(struct collision c, double *coarse, double *fine) {
    double w0 = frequency(&c);
    /* An end after which all have parted: slow viscoelastic impacts last as v^(-1/5), times 3. */
    double longest = 25 / w0;
    struct outcome exact = reference(&c, 1e-3 / w0, longest);
    struct outcome exacter = reference(&c, 2.5e-4 / w0, longest);
    assert_true(difference(&c, &exact, &exacter) < 2e-5); /* the reference's own error */
    struct outcome a = engine(&c, 16e-3 / w0, longest), b = engine(&c, 1e-3 / w0, longest);
    *coarse = fmax(*coarse, difference(&c, &a, &exacter));
    *fine = fmax(*fine, difference(&c, &b, &exacter));
}

static void for_every_law(void (*adapt)(struct collision *c), bool jumps) {
    const double w0_dt = 1e-3;
    for (size_t l = 0; l < rk_law_registry.count; l++) {
        for (size_t f = 0; f < rk_friction_registry.count; f++) {
            double coarse = 0, fine = 0;
            for (int degrees = 0; degrees <= 90; degrees += 6) {
                struct collision c =
                    typical(rk_law_registry.pieces[l], rk_friction_registry.pieces[f],
                            degrees < 90 ? degrees : 89);
                adapt(&c);
                compare(c, &coarse, &fine);
            }
            bool spring = named(rk_friction_registry.pieces[f], "cundall-strack");
            bool root = named(rk_law_registry.pieces[l], "viscoelastic");
            double bound = spring  ? 2.4 * w0_dt + (jumps ? 0.45 * w0_dt : 0)
                           : jumps ? 0.45 * w0_dt
                           : root  ? pow(w0_dt, 1.5)
                                   : w0_dt * w0_dt;
            double gain = jumps ? 6 : spring ? 12 : root ? 32 : 128;
            if (!(fine < bound) || !(coarse / fine > gain)) {
                fail_msg("%s, %s: errors %.2e and %.2e, ratio %.1f; at most %.2e, at least %.0f",
                         rk_law_registry.pieces[l]->name, rk_friction_registry.pieces[f]->name,
                         coarse, fine, coarse / fine, bound, gain);
            }
        }
    }
}

static void alike(struct collision *c) {
    (void)c;
}

static void unlike_and_spinning(struct collision *c) {
    c->radius[1] = 0.8;
    c->mass[1] = 0.64;
    c->spin[0] = 1;
    c->spin[1] = -0.7;
}

static void at_a_wall(struct collision *c) {
    c->wall = true;
    c->spin[0] = 0.8;
}

static void pulling(struct collision *c) {
    c->tension = kit_piece(&rk_tension_registry, "keep");
}

static void capped_by_the_spring(struct collision *c) {
    c->cap = kit_piece(&rk_cap_registry, "elastic");
    c->radius[1] = 0.8;
    c->mass[1] = 0.64;
}

static void equal_discs_collide_as_theory_says(void **state) {
    (void)state;
    for_every_law(alike, false);
}

static void unequal_spinning_discs_do(void **state) {
    (void)state;
    for_every_law(unlike_and_spinning, false);
}

static void a_disc_at_a_wall_does(void **state) {
    (void)state;
    for_every_law(at_a_wall, false);
}

static void discs_whose_dashpots_pull_do(void **state) {
    (void)state;
    for_every_law(pulling, true);
}

static void discs_whose_friction_is_capped_by_the_spring_do(void **state) {
    (void)state;
    for_every_law(capped_by_the_spring, false);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_discs_collide_as_theory_says),
        cmocka_unit_test(unequal_spinning_discs_do),
        cmocka_unit_test(a_disc_at_a_wall_does),
        cmocka_unit_test(discs_whose_dashpots_pull_do),
        cmocka_unit_test(discs_whose_friction_is_capped_by_the_spring_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
