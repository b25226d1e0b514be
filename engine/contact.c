#include "engine/contact.h"

#include "engine/engine.h"

#include <math.h>
#include <stddef.h>

const struct rk_piece rk_law_linear = {
    "linear", "spring and dashpot: fn = kn delta + gamma ddelta/dt (Martins 2021, eqs. 6-7)"};
static const struct rk_piece *const laws[] = {&rk_law_linear};
const struct rk_registry rk_law_registry = {"law", "normal force of a contact", laws, 1};

const struct rk_piece rk_friction_none = {
    "none", "smooth grains: no tangential force, no rotation, no history kept"};
const struct rk_piece rk_friction_cundall_strack = {
    "cundall-strack", "tangential spring with a Coulomb cap mu fn (Martins 2021, eq. 10)"};
static const struct rk_piece *const frictions[] = {&rk_friction_none, &rk_friction_cundall_strack};
const struct rk_registry rk_friction_registry = {"friction", "tangential force of a contact",
                                                 frictions, 2};

const struct rk_piece rk_tension_cut = {"cut", "dry grains only push: fn is cut at 0"};
const struct rk_piece rk_tension_keep = {
    "keep", "the dashpot may pull at the end of a contact, as in the code of Martins 2021"};
static const struct rk_piece *const tensions[] = {&rk_tension_cut, &rk_tension_keep};
const struct rk_registry rk_tension_registry = {
    "tension", "what happens to a negative normal force", tensions, 2};

#define AT(member) offsetof(struct rk_contact_spec, member)
const struct rk_param rk_contact_params[RK_CONTACT_PARAMS] = {
    {.name = "law",
     .type = RK_PARAM_PIECE,
     .offset = AT(law),
     .unit = "",
     .choice = "linear",
     .choices = &rk_law_registry,
     .doc = "normal force"},
    {.name = "friction",
     .type = RK_PARAM_PIECE,
     .offset = AT(friction),
     .unit = "",
     .choice = "cundall-strack",
     .choices = &rk_friction_registry,
     .doc = "tangential force"},
    {.name = "tension",
     .type = RK_PARAM_PIECE,
     .offset = AT(tension),
     .unit = "",
     .choice = "cut",
     .choices = &rk_tension_registry,
     .doc = "negative normal force"},
    {.name = "kn",
     .type = RK_PARAM_REAL,
     .offset = AT(kn),
     .unit = "m g/d",
     .value = 1000,
     .low = 0,
     .above_low = true,
     .high = 1e15,
     .doc = "normal stiffness"},
    {.name = "kt",
     .type = RK_PARAM_REAL,
     .offset = AT(kt),
     .unit = "m g/d",
     .value = 750,
     .low = 0,
     .high = 1e15,
     .doc = "tangential stiffness (used with friction)"},
    {.name = "mu",
     .type = RK_PARAM_REAL,
     .offset = AT(mu),
     .unit = "",
     .value = 0.5,
     .low = 0,
     .high = 1e6,
     .doc = "coefficient of friction (used with friction)"},
    {.name = "damping",
     .type = RK_PARAM_REAL,
     .offset = AT(damping),
     .unit = "",
     .value = 1,
     .low = 0,
     .high = 1e3,
     .doc = "gamma / (2 sqrt(kn m_min)), m_min the smallest grain's mass; 1 is Martins 2021"},
};
#undef AT

double rk_contact_gamma(const struct rk_contact_spec *contact, double smallest) {
    return contact->damping * 2 * sqrt(contact->kn * smallest);
}

struct rk_contact_law rk_contact_law_of(const struct rk_scene_spec *spec, double dt) {
    return (struct rk_contact_law){
        .kn = spec->contact.kn,
        .gamma = spec->gamma,
        .kt_dt = spec->contact.kt * dt,
        .mu = spec->contact.mu,
        .least = spec->contact.tension == &rk_tension_keep ? -INFINITY : 0,
    };
}
