#include "engine/contact.h"

#include "engine/integrator.h"

#include <math.h>
#include <stddef.h>

/* ---- Tables -----------------------------------------------------------------------------------
 */

const struct rk_normal_law rk_law_linear = {
    {"linear", "spring and dashpot: fn = kn delta + gamma ddelta/dt (Martins 2021, eqs. 6-7)"},
    RK_LINEAR};
const struct rk_normal_law rk_law_mass_damped = {
    {"mass-damped", "spring, and dashpot in proportion to the reduced mass (Foley 2010, eq. 2.10)"},
    RK_MASS_DAMPED};
const struct rk_normal_law rk_law_viscoelastic = {
    {"viscoelastic",
     "Y sqrt(Reff delta) (delta + A ddelta/dt): viscoelastic spheres (Foley 2010, eq. 2.9)"},
    RK_VISCOELASTIC};
static const struct rk_piece *const laws[] = {&rk_law_linear.piece, &rk_law_mass_damped.piece,
                                              &rk_law_viscoelastic.piece};
const struct rk_registry rk_law_registry = {"law", "normal force of a contact", laws, 3};

const struct rk_friction rk_friction_none = {
    {"none", "smooth grains: no tangential force, no rotation, no history kept"}, RK_SMOOTH};
const struct rk_friction rk_friction_cundall_strack = {
    {"cundall-strack", "tangential spring with a Coulomb cap mu fn (Martins 2021, eq. 10)"},
    RK_CUNDALL_STRACK};
const struct rk_friction rk_friction_haff_werner = {
    {"haff-werner", "viscous with a Coulomb cap, without memory (Foley 2010, eq. 2.12)"},
    RK_HAFF_WERNER};
static const struct rk_piece *const frictions[] = {
    &rk_friction_none.piece, &rk_friction_cundall_strack.piece, &rk_friction_haff_werner.piece};
const struct rk_registry rk_friction_registry = {"friction", "tangential force of a contact",
                                                 frictions, 3};

const struct rk_piece rk_rolling_none = {"none", "grains roll freely"};
const struct rk_piece rk_rolling_spring = {
    "spring", "torsional spring with a cap mu_rolling fn Reff (Martins 2021, sec. 3.1.1)"};
static const struct rk_piece *const rollings[] = {&rk_rolling_none, &rk_rolling_spring};
const struct rk_registry rk_rolling_registry = {"rolling resistance", "torque against rolling",
                                                rollings, 2};

const struct rk_piece rk_tension_cut = {"cut", "dry grains only push: fn is cut at 0"};
const struct rk_piece rk_tension_keep = {
    "keep", "the dashpot may pull at the end of a contact, as in the code of Martins 2021"};
static const struct rk_piece *const tensions[] = {&rk_tension_cut, &rk_tension_keep};
const struct rk_registry rk_tension_registry = {
    "tension", "what happens to a negative normal force", tensions, 2};

const struct rk_piece rk_cap_total = {"total", "Coulomb's cap is mu times the whole normal force"};
const struct rk_piece rk_cap_elastic = {
    "elastic", "mu times its spring alone (mu kn delta), as in the code of Martins 2021"};
static const struct rk_piece *const caps[] = {&rk_cap_total, &rk_cap_elastic};
const struct rk_registry rk_cap_registry = {"cap", "the normal force that bounds friction", caps,
                                            2};

#define REAL(member, units, fallback, least, open, most, text)                                     \
    {                                                                                              \
        .name = #member, .type = RK_PARAM_REAL,                                                    \
        .offset = offsetof(struct rk_contact_spec, member), .unit = units, .value = fallback,      \
        .low = least, .above_low = open, .high = most, .doc = text                                 \
    }
#define PIECE(member, fallback, registry, text)                                                    \
    {                                                                                              \
        .name = #member, .type = RK_PARAM_PIECE,                                                   \
        .offset = offsetof(struct rk_contact_spec, member), .unit = "", .choice = fallback,        \
        .choices = &registry, .doc = text                                                          \
    }
const struct rk_param rk_contact_params[RK_CONTACT_PARAMS] = {
    PIECE(law, "linear", rk_law_registry, "normal force"),
    PIECE(friction, "cundall-strack", rk_friction_registry, "tangential force"),
    PIECE(rolling, "none", rk_rolling_registry, "torque against rolling (used with friction)"),
    PIECE(tension, "cut", rk_tension_registry, "negative normal force"),
    {.name = "cap",
     .type = RK_PARAM_PIECE,
     .offset = offsetof(struct rk_contact_spec, cap),
     .unit = "",
     .choice = "total",
     .choices = &rk_cap_registry,
     .later = true,
     .doc = "normal force that bounds friction (used with friction)"},
    REAL(kn, "m g/d", 1000, 0, true, 1e15, "normal stiffness (linear, mass-damped)"),
    REAL(damping, "", 1, 0, false, 1e3,
         "gamma / (2 sqrt(kn m_min)), m_min the smallest grain's mass; 1 is Martins 2021"),
    REAL(restitution, "", 0, 0, false, 1,
         "0: use damping. Else the restitution of two smallest grains, from which damping follows"),
    REAL(kt, "m g/d", 750, 0, false, 1e15, "tangential stiffness (cundall-strack, rolling)"),
    REAL(mu, "", 0.5, 0, false, 1e6, "coefficient of friction (used with friction)"),
    REAL(gamma_t, "m sqrt(g/d)", 5, 0, false, 1e15, "tangential damping (haff-werner)"),
    REAL(mu_rolling, "", 0.05, 0, false, 1e6, "coefficient of rolling resistance (spring)"),
    REAL(young, "m g/d^2", 1e4, 0, true, 1e15, "elastic modulus of a grain (viscoelastic)"),
    REAL(loss, "sqrt(d/g)", 0.01, 0, false, 1e6, "A, the time of viscous loss (viscoelastic)"),
};
#undef REAL
#undef PIECE

/* ---- Damping ----------------------------------------------------------------------------------
 */

/* Restitution of the linear law against zeta = gamma/(2 sqrt(kn m_eff)). */
static double restitution_of(double zeta, bool cut) {
    if (zeta == 0) {
        return 1;
    }
    if (zeta < 1) {
        double w = sqrt(1 - zeta * zeta);
        return cut ? exp(-2 * zeta / w * atan2(w, zeta)) : exp(-M_PI * zeta / w);
    }
    if (!cut) {
        return 0;
    }
    double w = sqrt(zeta * zeta - 1);
    return w < 1e-7 ? exp(-2) : exp(-zeta / w * log((zeta + w) / (zeta - w)));
}

/* The zeta of a restitution in (0, 1]: it falls monotonically, so bisection finds it to rounding.
 */
static double zeta_of(double restitution, bool cut) {
    double low = 0, high = 1;
    while (restitution_of(high, cut) > restitution && high < 1e6) {
        high *= 2;
    }
    for (int halving = 0; halving < 100; halving++) {
        double middle = 0.5 * (low + high);
        *(restitution_of(middle, cut) > restitution ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

double rk_contact_gamma(const struct rk_contact_spec *contact, double smallest) {
    double gamma = contact->damping * 2 * sqrt(contact->kn * smallest);
    if (contact->restitution > 0) {
        bool cut = contact->tension != &rk_tension_keep;
        gamma = zeta_of(contact->restitution, cut) * 2 * sqrt(contact->kn * 0.5 * smallest);
    }
    /* The mass-damped law has gamma m_eff in its place: the same for two of the smallest. */
    return contact->law == &rk_law_mass_damped.piece ? gamma / (0.5 * smallest) : gamma;
}

enum rk_status rk_contact_check(const struct rk_contact_spec *contact, struct rk_error *err) {
    if (contact->restitution > 0 && contact->law == &rk_law_viscoelastic.piece) {
        return rk_fail_about(err, RK_EINVALID, "contact.restitution",
                             "contact.restitution: the restitution of viscoelastic grains depends "
                             "on their speed; set contact.loss instead");
    }
    double least = restitution_of(1e3, contact->tension != &rk_tension_keep);
    if (contact->restitution > 0 && contact->restitution < least) {
        return rk_fail_about(err, RK_EINVALID, "contact.restitution",
                             "contact.restitution: %g cannot be reached, the least a dashpot of "
                             "1000 times critical leaves is %.2g",
                             contact->restitution, least);
    }
    if (contact->rolling == &rk_rolling_spring && contact->friction == &rk_friction_none.piece) {
        return rk_fail_about(err, RK_EINVALID, "contact.rolling",
                             "contact.rolling: smooth grains do not turn; rolling resistance needs "
                             "a friction");
    }
    return RK_OK;
}

/* ---- Materials --------------------------------------------------------------------------------
 */

static double harmonic(double a, double b) {
    return a + b > 0 ? 2 * a * b / (a + b) : 0;
}

static struct rk_coefficients mixture(const struct rk_material *a, const struct rk_material *b,
                                      double dt) {
    return (struct rk_coefficients){
        .kn = harmonic(a->kn, b->kn),
        .gamma = harmonic(a->gamma, b->gamma),
        .young = 0.5 * harmonic(a->young, b->young),
        .loss = 0.5 * (a->loss + b->loss),
        .kt_dt = harmonic(a->kt, b->kt) * dt,
        .mu = sqrt(a->mu * b->mu),
        .gamma_t = harmonic(a->gamma_t, b->gamma_t),
        .mu_rolling = sqrt(a->mu_rolling * b->mu_rolling),
    };
}

void rk_contact_law_init(struct rk_contact_law *law, const struct rk_scene_spec *spec,
                         const struct rk_material *materials, size_t count, double dt) {
    law->normal = ((const struct rk_normal_law *)spec->contact.law)->normal;
    law->tangent = ((const struct rk_friction *)spec->contact.friction)->tangent;
    law->rolls = spec->contact.rolling == &rk_rolling_spring;
    law->elastic_cap = spec->contact.cap == &rk_cap_elastic;
    law->implicit = rk_integrator_of(spec->accuracy.integrator)->implicit;
    law->half_dt = 0.5 * dt;
    law->materials = count;
    law->least = spec->contact.tension == &rk_tension_keep ? -INFINITY : 0;
    for (size_t a = 0; a < count; a++) {
        for (size_t b = 0; b < count; b++) {
            law->of[a * count + b] = mixture(&materials[a], &materials[b], dt);
        }
    }
}

struct rk_material rk_contact_material(const struct rk_contact_spec *contact, double gamma) {
    return (struct rk_material){
        .kn = contact->kn,
        .gamma = gamma,
        .kt = contact->kt,
        .mu = contact->mu,
        .gamma_t = contact->gamma_t,
        .mu_rolling = contact->mu_rolling,
        .young = contact->young,
        .loss = contact->loss,
    };
}
