/* The largest stable time step: of one contact the integrators know it (rk_integrator_limit); here
 * it is found what the stiffest motion of a scene is. */
#include "engine/body.h"
#include "engine/contact.h"
#include "engine/groups.h"
#include "engine/integrator.h"
#include "engine/movers.h"

#include <math.h>

/* What resists a motion: spring and dashpot. */
struct bond {
    double stiffness, dashpot;
};

/* Of one contact of two of the smallest grains. The viscoelastic law is stiffer the deeper: an
 * overlap of a tenth of the radius, which no good run exceeds, stands for all. */
static struct bond bond_of(const struct rk_piece *law, const struct rk_coefficients *k,
                           double smallest) {
    struct bond bond = {k->kn, k->gamma};
    if (law == &rk_law_mass_damped.piece) {
        bond.dashpot = k->gamma * 0.5 * smallest;
    } else if (law == &rk_law_viscoelastic.piece) {
        double radius = sqrt(smallest);
        double scale = k->young * sqrt(0.5 * radius * 0.1 * radius);
        bond = (struct bond){1.5 * scale, scale * k->loss};
    }
    return bond;
}

/* The largest dt for mass x'' = -count (stiffness x + dashpot x'). */
static double motion_limit(const struct rk_piece *integrator, const struct bond *bond, double count,
                           double mass) {
    double w = sqrt(count * bond->stiffness / mass);
    double zeta = count * bond->dashpot / mass / (2 * w);
    return rk_integrator_of(integrator)->crowd * rk_integrator_limit(integrator, zeta) / w;
}

/* With friction there is a motion that may be faster: all turn the same way, and at six contacts
 * the slip is twice R omega, so that b omega'' = -12 kt/m omega or b omega' = -12 gamma_t/m omega,
 * b the share of m R^2 in the moment of inertia. The integrators say how far each may go:
 * `slip_spring` bounds (w h)^2, `slip_dashpot` b h. */
static double turning_limit(const struct rk_integrator *integrator,
                            const struct rk_contact_spec *contact, const struct rk_coefficients *k,
                            double inertia, double smallest) {
    double share = 12 / inertia;
    if (contact->friction == &rk_friction_cundall_strack.piece && k->mu > 0) {
        return sqrt(integrator->slip_spring * smallest / (share * k->kt_dt)); /* dt = 1 there */
    }
    if (contact->friction == &rk_friction_haff_werner.piece && k->mu > 0) {
        return integrator->slip_dashpot * smallest / (share * k->gamma_t);
    }
    return INFINITY;
}

/* The stiffest motion of a grain among six alike: springs and dashpots add up to 6 of each. */
static double crowd_limit(const struct rk_piece *integrator, const struct rk_contact_spec *contact,
                          const struct rk_coefficients *k, double inertia, double smallest) {
    const struct bond bond = bond_of(contact->law, k, smallest);
    return fmin(motion_limit(integrator, &bond, 6, smallest),
                turning_limit(rk_integrator_of(integrator), contact, k, inertia, smallest));
}

double rk_stable_step(const struct rk_piece *integrator, const struct rk_contact_spec *contact,
                      double gamma, double smallest) {
    const struct rk_coefficients k = {.kn = contact->kn,
                                      .gamma = gamma,
                                      .young = 0.5 * contact->young,
                                      .loss = contact->loss,
                                      .kt_dt = contact->kt,
                                      .mu = contact->mu,
                                      .gamma_t = contact->gamma_t};
    return crowd_limit(integrator, contact, &k, rk_body_disc.inertia, smallest);
}

/* ---- Of a scene ------------------------------------------------------------------------------ */

/* Contacts of a mover with grains that it does not carry. */
static size_t contacts_of(const struct rk_scene *scene, size_t row) {
    const struct rk_touching *t = &scene->touching;
    const uint32_t *group = scene->grains.group;
    size_t count = 0, walls = scene->spec.walls;
    for (size_t c = 0; row < walls && c < scene->wall_touching.count; c++) {
        count += scene->wall_touching.wall[c] == row;
    }
    for (size_t c = 0; row >= walls && c < t->count; c++) {
        count += group[t->first[c]] + group[t->second[c]] == row - walls + 1;
    }
    return count;
}

/* A lid of mass M with n contacts. No motion of bodies joined by springs is faster than twice what
 * the springs of the worst of them would give it alone, the others at rest: a spring's energy is at
 * most k (u_i^2 + u_j^2). Its own dashpot adds to those of the contacts. Lids take Verlet's steps.
 */
static double lid_limit(const struct rk_scene *scene, size_t row, const struct bond *bond) {
    const struct rk_mover *mover = rk_mover_at(scene, row);
    if (!rk_drive_of(&mover->drive)->inert) {
        return INFINITY;
    }
    const struct rk_piece *integrator = scene->spec.accuracy.integrator;
    double count = 2 * fmax(1, (double)contacts_of(scene, row));
    struct bond all = {bond->stiffness, bond->dashpot + mover->drive.damping / count};
    return fmin(motion_limit(integrator, &all, count, mover->drive.mass),
                motion_limit(NULL, &all, count, mover->drive.mass));
}

double rk_scene_stable_step(const struct rk_scene *scene) {
    const struct rk_scene_spec *spec = &scene->spec;
    const double inertia = rk_body_of(spec->body)->inertia;
    struct rk_contact_law law;
    struct bond stiffest = {0, 0};
    double limit = INFINITY;
    rk_contact_law_init(&law, spec, scene->materials, scene->material_count, 1);
    for (size_t k = 0; k < scene->material_count * scene->material_count; k++) {
        const struct bond bond = bond_of(spec->contact.law, &law.of[k], spec->smallest);
        stiffest.stiffness = fmax(stiffest.stiffness, bond.stiffness);
        stiffest.dashpot = fmax(stiffest.dashpot, bond.dashpot);
        if (bond.stiffness > 0) {
            limit = fmin(limit, crowd_limit(spec->accuracy.integrator, &spec->contact, &law.of[k],
                                            inertia, spec->smallest));
        }
    }
    for (size_t row = rk_mover_from(scene, 0); stiffest.stiffness > 0 && row < rk_mover_rows(scene);
         row = rk_mover_from(scene, row + 1)) {
        limit = fmin(limit, lid_limit(scene, row, &stiffest));
    }
    return limit;
}
