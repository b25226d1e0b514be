/* Maximum likelihood of one family on weighted points: everything is a search along one line.
 *
 * At a given shape the likelihood has one maximum over the scale and, for these symmetric families,
 * one near the median over the location; the two hardly depend on each other, so taking turns ends
 * after a few rounds. What is left is a function of the shape alone, the profile, whose slope is
 * the partial derivative (the others vanish at the maximum). Its root is the estimate, and where it
 * has dropped by half a chi-square lie the ends of the interval. */
#include "stats/numeric.h"
#include "stats/pdf_internal.h"

double rk_pdf_rising_root(double (*f)(double x, double *slope, void *context), void *context,
                          double start, double low, double high, double stride, double tolerance) {
    double x = start;
    for (int i = 0; i < 200; i++) {
        double slope, value = f(x, &slope, context);
        if (value == 0) { /* also where it starts: there is no step that would stay in place */
            break;
        }
        if (value > 0) {
            high = x;
        } else {
            low = x;
        }
        double step = value / slope;
        double next = isfinite(step) ? x - fmax(-stride, fmin(stride, step)) : low;
        if (!(next > low && next < high)) {
            next = isinf(high) ? low + stride : isinf(low) ? high - stride : 0.5 * (low + high);
        }
        bool done = fabs(next - x) <= tolerance;
        x = next;
        if (done) {
            break;
        }
    }
    return x;
}

double rk_pdf_profile(const struct rk_pdf_points *points, bool fixed, struct rk_pdf_curve *curve,
                      double *slope) {
    const struct rk_pdf_methods *methods = curve->family->methods;
    for (int round = 0; round < 60; round++) {
        double location = curve->location, scale = curve->scale;
        curve->scale = methods->fit_scale(points, curve);
        if (fixed) {
            break;
        }
        curve->location = methods->fit_location(points, curve);
        if (fabs(curve->location - location) <= 1e-9 * curve->scale &&
            fabs(curve->scale - scale) <= 1e-9 * curve->scale) {
            break;
        }
    }
    struct rk_pdf_sums sums = methods->sums(points->z, points->w, points->count, curve);
    if (slope) {
        *slope = sums.shape;
    }
    return sums.log_density;
}

struct search {
    const struct rk_pdf_points *points;
    bool fixed;
    struct rk_pdf_curve curve;
    double target;
};

static double slope_at(double shape, void *context) {
    struct search *search = context;
    double slope;
    search->curve.shape = shape;
    rk_pdf_profile(search->points, search->fixed, &search->curve, &slope);
    return slope;
}

static double height_at(double shape, void *context) {
    struct search *search = context;
    search->curve.shape = shape;
    return rk_pdf_profile(search->points, search->fixed, &search->curve, NULL) - search->target;
}

/* Brent's method to a tolerance: the root of f between a and b, where it has the values fa and fb
 * of opposite signs. By secants kept inside (Illinois rule), which needs fewer calls than rk_root's
 * last digits. */
static double root_between(double (*f)(double, void *), void *context, double a, double fa,
                           double b, double fb, double tolerance) {
    int side = 0;
    for (int i = 0; i < 100 && fabs(b - a) > tolerance; i++) {
        double x = (a * fb - b * fa) / (fb - fa);
        if (!(x > fmin(a, b) && x < fmax(a, b))) {
            x = 0.5 * (a + b);
        }
        double fx = f(x, context);
        if (fx == 0 || !isfinite(fx)) {
            return x;
        }
        double moved;
        if ((fx > 0) == (fa > 0)) {
            moved = fabs(x - a);
            a = x;
            fa = fx;
            fb = side == 1 ? 0.5 * fb : fb;
            side = 1;
        } else {
            moved = fabs(x - b);
            b = x;
            fb = fx;
            fa = side == -1 ? 0.5 * fa : fa;
            side = -1;
        }
        if (moved < 0.1 * tolerance) {
            return x;
        }
    }
    return 0.5 * (a + b);
}

enum { SCAN = 15 };

/* The i-th shape of the scan over the family's range. */
static double scan_shape(const struct rk_pdf_family *family, int i) {
    double part = (double)i / (SCAN - 1);
    return family->low > 0 ? family->low * pow(family->high / family->low, part)
                           : family->low + part * (family->high - family->low);
}

/* The best shape of the scan, the location being left where it is: near enough to begin with. */
static int scan(const struct search *from) {
    struct search where = *from, *search = &where;
    struct rk_pdf_curve start = from->curve;
    double best = -INFINITY;
    int at = 0;
    search->fixed = true;
    search->target = 0;
    for (int i = 0; i < SCAN; i++) {
        search->curve = start;
        double height = height_at(scan_shape(start.family, i), search);
        if (height > best) {
            best = height;
            at = i;
        }
    }
    return at;
}

/* A bracket of the maximum: from the middle outwards until the slope changes sign. */
static double climb(struct search *search, double middle, double step) {
    const struct rk_pdf_family *family = search->curve.family;
    double a = middle, slope = slope_at(a, search), direction = slope > 0 ? 1 : -1;
    if (slope == 0) {
        return a;
    }
    for (int i = 0; i < 60; i++) {
        double b = fmin(fmax(a + direction * step, family->low), family->high);
        double next = slope_at(b, search);
        if ((next > 0) != (slope > 0)) {
            return root_between(slope_at, search, a, slope, b, next, 1e-9);
        }
        if (b == family->low || b == family->high) {
            return b;
        }
        a = b;
        slope = next;
        step *= 2;
    }
    return a;
}

double rk_pdf_maximise(const struct rk_pdf_points *points, bool fixed, bool warm,
                       struct rk_pdf_curve *curve) {
    const struct rk_pdf_family *family = curve->family;
    struct search search = {points, fixed, *curve, 0};
    double middle = curve->shape, step = fmax(2 / sqrt(points->total), 1e-4);
    if (!warm) {
        int at = scan(&search);
        middle = scan_shape(family, at);
        step = 0.5 * fabs(scan_shape(family, at > 0 ? at - 1 : 1) - middle);
    }
    search.curve.shape = climb(&search, middle, fmin(step, 0.1 * (family->high - family->low)));
    double height = rk_pdf_profile(points, fixed, &search.curve, NULL);
    *curve = search.curve;
    return height;
}

static double end_of(struct search *search, const struct rk_pdf_curve *best, double drop,
                     double step, double end) {
    double inner = best->shape, height = drop;
    search->curve = *best;
    for (int i = 0; i < 60; i++) {
        double outer = inner + step;
        bool last = step > 0 ? outer >= end : outer <= end;
        outer = last ? end : outer;
        double next = height_at(outer, search);
        if (!(next > 0)) {
            double tolerance = 1e-6 * fabs(outer - best->shape);
            return root_between(height_at, search, inner, height, outer, next, tolerance);
        }
        if (last) {
            return end;
        }
        inner = outer;
        height = next;
        step *= 1.6;
    }
    return end;
}

void rk_pdf_profile_ends(const struct rk_pdf_points *points, bool fixed,
                         const struct rk_pdf_curve *best, double log_likelihood, double drop,
                         double *low, double *high) {
    struct search search = {points, fixed, *best, log_likelihood - drop};
    const struct rk_pdf_family *family = best->family;
    double covariance[3][3], step = 0.1 * (family->high - family->low);
    if (rk_pdf_covariance(points, fixed, best, covariance)) {
        step = fmin(step, 1.1 * sqrt(2 * drop * covariance[2][2]));
    }
    *low = end_of(&search, best, drop, -step, family->low);
    *high = end_of(&search, best, drop, step, family->high);
}

/* ---- Curvature ----------------------------------------------------------------------------- */

static void shift(struct rk_pdf_curve *curve, int which, double by) {
    if (which == 0) {
        curve->location += by;
    } else if (which == 1) {
        curve->scale *= exp(by);
    } else {
        curve->shape += by;
    }
}

/* Invert a symmetric positive 3 x 3 matrix by cofactors, scaled to a unit diagonal first. */
static bool invert(double m[3][3], double inverse[3][3]) {
    double scale[3];
    for (int i = 0; i < 3; i++) {
        if (!(m[i][i] > 0)) {
            return false;
        }
        scale[i] = 1 / sqrt(m[i][i]);
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            m[i][j] *= scale[i] * scale[j];
        }
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            inverse[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    }
    double determinant =
        m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
    if (!(determinant > 1e-12)) {
        return false;
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            inverse[i][j] *= scale[i] * scale[j] / determinant;
        }
    }
    return true;
}

bool rk_pdf_covariance(const struct rk_pdf_points *points, bool fixed,
                       const struct rk_pdf_curve *curve, double covariance[3][3]) {
    /* Location: a step that still covers many points, for the score may have kinks at them. */
    double steps[3] = {0.3 * curve->scale * pow(points->total, -0.25), 1e-4, 1e-4};
    double m[3][3] = {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    fixed = fixed || curve->shape <= curve->family->methods->cusped;
    for (int i = fixed ? 1 : 0; i < 3; i++) {
        struct rk_pdf_sums at[2];
        for (int sign = 0; sign < 2; sign++) {
            struct rk_pdf_curve moved = *curve;
            shift(&moved, i, sign ? steps[i] : -steps[i]);
            at[sign] = curve->family->methods->sums(points->z, points->w, points->count, &moved);
        }
        m[i][0] = fixed ? 0 : -(at[1].location - at[0].location) / (2 * steps[i]);
        m[i][1] = -(at[1].log_scale - at[0].log_scale) / (2 * steps[i]);
        m[i][2] = -(at[1].shape - at[0].shape) / (2 * steps[i]);
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < i; j++) {
            m[i][j] = m[j][i] = 0.5 * (m[i][j] + m[j][i]);
        }
    }
    bool positive = invert(m, covariance);
    if (fixed) {
        covariance[0][0] = covariance[0][1] = covariance[0][2] = 0;
        covariance[1][0] = covariance[2][0] = 0;
    }
    return positive;
}

static bool at_limit(const struct rk_pdf_family *family, double shape) {
    double margin = 1e-3 * (family->high - family->low);
    return shape <= family->low + 0.1 * margin || shape >= family->high - margin;
}

bool rk_pdf_at_limit(const struct rk_pdf_curve *curve) {
    return at_limit(curve->family, curve->shape);
}

void rk_pdf_bound(struct rk_interval *shape, const struct rk_pdf_family *family, double low,
                  double high) {
    shape->low = at_limit(family, low) ? -INFINITY : low;
    shape->high = at_limit(family, high) ? INFINITY : high;
}
