/* The loops over contacts of engine/kernel.h, included by engine/kernel_body.h. */

/* Which of the variants of the contact passes is meant: always constants, so that what a scene
 * does not use is not in its loop. */
struct flavour {
    enum rk_normal normal;
    enum rk_tangent tangent;
    bool rolls, mixed;
    bool implicit;
};

/* Eight contacts, of pairs or at walls: what the laws of engine/contact.h are functions of. */
struct meeting {
    lanes overlap, parting; /* parting = - d(overlap)/dt */
    lanes slip, spin;
    lanes reduced_radius, reduced_mass;
    lanes rough; /* 0 at a smooth wall */
    lanes ease;  /* implicit: of the two grains together */
};

struct answer {
    lanes fn, ft, moment;
};

#define COEFFICIENT(member)                                                                        \
    (f.mixed ? lanes_gather(&law->of[0].member, index) : lanes_all(law->of[0].member))

static INLINE lanes normal_force(const struct flavour f, const struct rk_contact_law *law,
                                 const uint32_t *index, const struct meeting *m, lanes parting) {
    if (f.normal == RK_LINEAR) {
        return law_linear(m->overlap, parting, COEFFICIENT(kn), COEFFICIENT(gamma));
    }
    if (f.normal == RK_MASS_DAMPED) {
        return law_mass_damped(m->overlap, parting, m->reduced_mass, COEFFICIENT(kn),
                               COEFFICIENT(gamma));
    }
    return law_viscoelastic(m->overlap, parting, m->reduced_radius, COEFFICIENT(young),
                            COEFFICIENT(loss));
}

/* What an implicit integrator needs of it: - d(normal force)/d(parting). */
static INLINE lanes dashpot_of(const struct flavour f, const struct rk_contact_law *law,
                               const uint32_t *index, const struct meeting *m) {
    if (f.normal == RK_LINEAR) {
        return COEFFICIENT(gamma);
    }
    if (f.normal == RK_MASS_DAMPED) {
        return COEFFICIENT(gamma) * m->reduced_mass;
    }
    return COEFFICIENT(young) * COEFFICIENT(loss) * lanes_root(m->reduced_radius * m->overlap);
}

static INLINE struct answer resist(const struct flavour f, const struct rk_contact_law *law,
                                   const uint32_t *index, const struct meeting *m, lanes fn,
                                   lanes ft, lanes moment) {
    struct answer a = {normal_force(f, law, index, m, m->parting), ft, moment};
    if (f.implicit) {
        a.fn = implicit_relax(a.fn, fn, law->half_dt * dashpot_of(f, law, index, m) * m->ease);
    }
    a.fn = lanes_larger(a.fn, lanes_all(law->least));
    lanes capped = a.fn; /* Coulomb's cap is mu times this */
    if (f.tangent != RK_SMOOTH && law->elastic_cap) {
        capped = normal_force(f, law, index, m, lanes_all(0));
    }
    if (f.tangent == RK_CUNDALL_STRACK) {
        a.ft = friction_cundall_strack(ft, m->slip, capped, COEFFICIENT(kt_dt),
                                       COEFFICIENT(mu) * m->rough);
    } else if (f.tangent == RK_HAFF_WERNER) {
        a.ft =
            friction_haff_werner(m->slip, capped, COEFFICIENT(gamma_t), COEFFICIENT(mu) * m->rough);
    }
    if (f.rolls) {
        a.moment = rolling_spring(moment, m->spin, a.fn, m->reduced_radius, COEFFICIENT(kt_dt),
                                  COEFFICIENT(mu_rolling) * m->rough);
    }
    return a;
}

/* Where the coefficients of eight pairs of materials begin, counted in doubles. */
static INLINE void mix(const struct rk_contact_law *law, const uint32_t *material,
                       const uint32_t *first, const uint32_t *second, uint32_t index[LANES]) {
    for (int l = 0; l < LANES; l++) {
        uint32_t i = first[l] / RK_ROW_WIDTH, j = second[l] / RK_ROW_WIDTH;
        index[l] =
            (uint32_t)((material[i] * law->materials + material[j]) * (uint32_t)RK_COEFFICIENTS);
    }
}

/* How the second grains of LANES close pairs lie and move as their first grains see it. */
struct sight {
    lanes dx, dy, ux, uy;
    lanes d2, reach;
    lanes_mask touch;
};

/* Close pairs c to c + LANES. */
static INLINE struct sight look(const struct rk_grains *grains, const struct rk_close *close,
                                size_t c) {
    struct sight s;
    lanes_row_differences(grains->motion, close->first + c, close->second + c, &s.dx, &s.dy, &s.ux,
                          &s.uy);
    if (close->shift) {
        s.dx += lanes_load(close->shift + c);
    }
    s.reach = lanes_load(close->reach + c);
    s.d2 = s.dx * s.dx + s.dy * s.dy;
    s.touch = lanes_below(s.d2, s.reach * s.reach);
    return s;
}

/* The same along the line of their centres; of those that do not touch all but ux and uy is 0, and
 * so is what the laws make of it. */
struct view {
    lanes nx, ny, ux, uy;
    lanes overlap, share; /* share: distance over the sum of the radii */
    lanes_mask touch;
};

static INLINE struct view measure(const struct flavour f, const struct sight *s) {
    lanes distance = lanes_only(s->touch, lanes_root(s->d2)), quotient = lanes_all(0), inverse;
    if (f.tangent == RK_SMOOTH) { /* root and division at the same time */
        inverse = distance * lanes_only(s->touch, 1 / s->d2);
    } else { /* one division for the two that are needed */
        quotient = lanes_only(s->touch, 1 / (distance * s->reach));
        inverse = s->reach * quotient;
    }
    return (struct view){.nx = s->dx * inverse,
                         .ny = s->dy * inverse,
                         .ux = s->ux,
                         .uy = s->uy,
                         .overlap = lanes_only(s->touch, s->reach - distance),
                         .share = lanes_only(s->touch, s->d2 * quotient),
                         .touch = s->touch};
}

/* Those that do not touch get a force of 0, even where it is relaxed from an earlier one, and
 * nothing to remember. */
static INLINE void decide(const struct flavour f, const struct rk_grains *grains,
                          const struct rk_contact_law *law, const struct rk_close *close, size_t c,
                          const struct view *v, double *rows) {
    const bool rotates = f.tangent != RK_SMOOTH;
    const uint32_t *i = close->first + c, *j = close->second + c;
    uint32_t index[LANES];
    struct meeting m = {.rough = lanes_all(1), .overlap = v->overlap};
    lanes nx = v->nx, ny = v->ny;
    lanes ux = v->ux, uy = v->uy;
    lanes fn = lanes_all(0), ft = fn, moment = fn, radius_i = fn, radius_j = fn;
    lanes arm_i = fn, arm_j = fn;
    m.parting = ux * nx + uy * ny;
    if (rotates || f.normal == RK_VISCOELASTIC) {
        radius_i = lanes_load(close->radius_first + c);
        radius_j = lanes_load(close->radius_second + c);
    }
    if (f.normal == RK_MASS_DAMPED) {
        lanes mass_i = lanes_gather_beside(grains->mass, i),
              mass_j = lanes_gather_beside(grains->mass, j);
        m.reduced_mass = mass_i * mass_j / (mass_i + mass_j);
    }
    if (f.normal == RK_VISCOELASTIC || f.rolls) {
        m.reduced_radius = radius_i * radius_j / (radius_i + radius_j);
    }
    if (rotates) {
        lanes omega_i = lanes_gather_beside(grains->omega, i),
              omega_j = lanes_gather_beside(grains->omega, j);
        lanes share = v->share;
        arm_i = radius_i * share;
        arm_j = radius_j * share;
        m.slip = uy * nx - ux * ny - arm_i * omega_i - arm_j * omega_j;
        m.spin = omega_i - omega_j;
    }
    if (f.mixed) {
        mix(law, grains->material, i, j, index);
    }
    if (f.implicit) {
        m.ease = lanes_gather_beside(grains->ease, i) + lanes_gather_beside(grains->ease, j);
        fn = lanes_load(close->history[RK_HISTORY_FN] + c);
    }
    if (f.tangent == RK_CUNDALL_STRACK) {
        ft = lanes_load(close->history[RK_HISTORY_FT] + c);
    }
    if (f.rolls) {
        moment = lanes_load(close->history[RK_HISTORY_MOMENT] + c);
    }
    struct answer a = resist(f, law, index, &m, fn, ft, moment);
    a.fn = f.implicit ? lanes_only(v->touch, a.fn) : a.fn;
    lanes_store(close->history[RK_HISTORY_FN] + c, a.fn);
    lanes fx = a.fn * nx, fy = a.fn * ny;
    if (!rotates) {
        lanes_store_twos(rows, fx, fy);
        return;
    }
    a.ft = lanes_only(v->touch, a.ft);
    lanes_store(close->history[RK_HISTORY_FT] + c, a.ft);
    lanes turn_i = arm_i * a.ft, turn_j = -(arm_j * a.ft);
    if (f.rolls) {
        a.moment = lanes_only(v->touch, a.moment);
        lanes_store(close->history[RK_HISTORY_MOMENT] + c, a.moment);
        turn_i += a.moment;
        turn_j += a.moment;
    }
    lanes_store_rows(rows, fx - a.ft * ny, fy + a.ft * nx, turn_i, turn_j);
}

/* For every grain there is one order in which its forces are ever added up: its weight, contacts in
 * which it is second, contacts in which it is first, each in ascending order of the other grain;
 * then walls. */
static INLINE double *pair_beside(double *force, size_t row) {
    return (double *)((char *)force + row * (sizeof(double) / 2));
}

static INLINE void give_first(bool rotates, double *force, size_t row, const double *rows,
                              size_t l) {
    if (rotates) {
        four_subtract(force + row, rows + 4 * l);
    } else {
        two_subtract(pair_beside(force, row), rows + lanes_row_of_two(l));
    }
}

static INLINE void give_second(bool rotates, double *force, size_t row, const double *rows,
                               size_t l) {
    if (rotates) {
        four_add_exchanged(force + row, rows + 4 * l);
    } else {
        two_add(pair_beside(force, row), rows + lanes_row_of_two(l));
    }
}

/* The rows of close pairs c to c + LANES: to the grains of this thread only, which are both of each
 * pair if they are `inner` ones. */
static INLINE void give(bool rotates, bool inner, double *force, const double *rows,
                        const struct rk_close *close, size_t c) {
    const uint32_t *i = close->first + c, *j = close->second + c;
    for (size_t l = 0; l < LANES; l++) {
        if (inner || c >= close->own) {
            give_first(rotates, force, i[l], rows, l);
        }
        if (inner || j[l] < close->last) {
            give_second(rotates, force, j[l], rows, l);
        }
    }
}

/* Close pairs begin to end; gives how many touch. Three groups of them are under way at any time:
 * while the forces of one are summed, roots and quotients of the next are worked out and the rows
 * of the one behind that are brought together, so that none of these waits for another. What lies
 * behind the last pairs is looked at too: fill_up of engine/close.c puts fillers there. */
static INLINE size_t push_stretch(const struct flavour f, bool inner,
                                  const struct rk_grains *grains, const struct rk_contact_law *law,
                                  const struct rk_close *close, size_t begin, size_t end) {
    _Alignas(RK_CACHE_LINE) double rows[4 * LANES];
    size_t touching = 0;
    if (begin >= end) {
        return 0;
    }
    struct sight sight = look(grains, close, begin);
    struct view view, next = measure(f, &sight);
    sight = look(grains, close, begin + LANES);
    for (size_t c = begin; c < end; c += LANES) {
        view = next;
        next = measure(f, &sight);
        sight = look(grains, close, c + 2 * LANES);
        decide(f, grains, law, close, c, &view, rows);
        give(f.tangent != RK_SMOOTH, inner, grains->force, rows, close, c);
        touching += lanes_tally(view.touch);
    }
    return touching;
}

/* Ghosts, pairs of this thread's grains, and those that may have a grain of another thread: in
 * their order. */
static INLINE void push(const struct flavour f, struct rk_grains *grains,
                        const struct rk_contact_law *law, struct rk_close *list) {
    const struct rk_close close = *list; /* nothing that is stored can change these */
    const struct rk_grains g = *grains;
    const size_t bounds[] = {0, close.own, close.crossing, close.end};
    list->touching = 0;
    for (int k = 0; k < 3; k++) {
        if (k == 1) {
            list->touching += push_stretch(f, true, &g, law, &close, bounds[1], bounds[2]);
        } else {
            size_t touching = push_stretch(f, false, &g, law, &close, bounds[k], bounds[k + 1]);
            list->touching += k == 0 ? 0 : touching;
        }
    }
}

/* The same at walls, with the wall as an infinitely large and heavy partner. */
static INLINE void press(const struct flavour f, struct rk_grains *grains,
                         const struct rk_contact_law *law, struct rk_wall_touching *touching) {
    const bool rotates = f.tangent != RK_SMOOTH;
    const lanes none = lanes_all(0);
    for (size_t c = 0; c < touching->count; c += LANES) { /* arrays are filled up to a block */
        const uint32_t *i = touching->grain + c;
        uint32_t index[LANES];
        struct meeting m = {.rough = lanes_load(touching->rough + c)};
        lanes nx = lanes_load(touching->nx + c), ny = lanes_load(touching->ny + c);
        lanes ux = lanes_load(touching->vx + c) - lanes_gather_column(grains->motion + 2, i);
        lanes uy = lanes_load(touching->vy + c) - lanes_gather_column(grains->motion + 3, i);
        lanes radius = lanes_gather(grains->radius, i), fn = none, ft = none, moment = none;
        m.overlap = lanes_load(touching->overlap + c);
        m.parting = ux * nx + uy * ny;
        m.reduced_radius = radius;
        m.reduced_mass = lanes_gather(grains->mass, i);
        if (rotates) {
            lanes omega = lanes_gather(grains->omega, i);
            m.slip = uy * nx - ux * ny - radius * omega;
            m.spin = omega - lanes_load(touching->omega + c);
            ft = lanes_load(touching->history[RK_HISTORY_FT] + c);
            moment = lanes_load(touching->history[RK_HISTORY_MOMENT] + c);
        }
        if (f.implicit) {
            m.ease = lanes_gather(grains->ease, i);
            fn = lanes_load(touching->history[RK_HISTORY_FN] + c);
        }
        if (f.mixed) {
            for (int l = 0; l < LANES; l++) {
                index[l] = (uint32_t)((grains->material[i[l]] * law->materials +
                                       touching->material[c + (size_t)l]) *
                                      (uint32_t)RK_COEFFICIENTS);
            }
        }
        struct answer a = resist(f, law, index, &m, fn, ft, moment);
        lanes fx = a.fn * nx, fy = a.fn * ny, turn = none;
        if (rotates) {
            fx -= a.ft * ny;
            fy += a.ft * nx;
            turn = -(radius * a.ft);
        }
        if (f.rolls) {
            turn -= a.moment;
        }
        lanes_store(touching->fn + c, a.fn);
        if (f.implicit) {
            lanes_store(touching->history[RK_HISTORY_FN] + c, a.fn);
        }
        lanes_store(touching->history[RK_HISTORY_FT] + c, a.ft);
        lanes_store(touching->history[RK_HISTORY_MOMENT] + c, a.moment);
        lanes_store_rows(touching->force + RK_ROW_WIDTH * c, fx, fy, turn, none);
    }
}
