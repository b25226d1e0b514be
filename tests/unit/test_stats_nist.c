/* Nonlinear least squares against certified values: NIST Statistical Reference Datasets, nonlinear
 * regression (www.itl.nist.gov/div898/strd, public domain; certified to 11 digits).
 *
 * That data and certified values are typed correctly is tested before anything is fitted: the
 * residual sum of squares at the certified parameters must be the certified one. Misra1a, b, d, c
 * are y = b1 (1 - e_q(-b2 x)) with q = 1, 3/2, 2, 3, the same data each time; BoxBOD is the
 * saturation exponential. */
#include "stats/least_squares.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { MOST = 40 };

struct problem {
    const char *name;
    double (*model)(double x, const double *b, double *gradient, const void *context);
    size_t points, params;
    double start[2][RK_LEAST_SQUARES_PARAMS];
    double certified[RK_LEAST_SQUARES_PARAMS], deviation[RK_LEAST_SQUARES_PARAMS], residual;
    const double *x, *y;
};

static const double misra_x[] = {77.6,  114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                                 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0};
static const double misra_y[] = {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                                 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78};
static const double box_x[] = {1, 2, 3, 5, 7, 10};
static const double box_y[] = {109, 149, 149, 191, 213, 224};
static const double mgh17_x[] = {0,   10,  20,  30,  40,  50,  60,  70,  80,  90,  100,
                                 110, 120, 130, 140, 150, 160, 170, 180, 190, 200, 210,
                                 220, 230, 240, 250, 260, 270, 280, 290, 300, 310, 320};
static const double mgh17_y[] = {0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818,
                                 0.784, 0.751, 0.718, 0.685, 0.658, 0.628, 0.603, 0.580, 0.558,
                                 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438,
                                 0.431, 0.424, 0.420, 0.414, 0.411, 0.406};
static const double lanczos_x[] = {0.00, 0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.35,
                                   0.40, 0.45, 0.50, 0.55, 0.60, 0.65, 0.70, 0.75,
                                   0.80, 0.85, 0.90, 0.95, 1.00, 1.05, 1.10, 1.15};
static const double lanczos_y[] = {2.5134, 2.0443, 1.6684, 1.3664, 1.1232, 0.9269, 0.7679, 0.6389,
                                   0.5338, 0.4479, 0.3776, 0.3197, 0.2720, 0.2325, 0.1997, 0.1723,
                                   0.1493, 0.1301, 0.1138, 0.1000, 0.0883, 0.0783, 0.0698, 0.0624};
static const double eckerle_x[] = {400.0, 405.0, 410.0, 415.0, 420.0, 425.0, 430.0, 435.0, 436.5,
                                   438.0, 439.5, 441.0, 442.5, 444.0, 445.5, 447.0, 448.5, 450.0,
                                   451.5, 453.0, 454.5, 456.0, 457.5, 459.0, 460.5, 462.0, 463.5,
                                   465.0, 470.0, 475.0, 480.0, 485.0, 490.0, 495.0, 500.0};
static const double eckerle_y[] = {0.0001575, 0.0001699, 0.0002350, 0.0003102, 0.0004917, 0.0008710,
                                   0.0017418, 0.0046400, 0.0065895, 0.0097302, 0.0149002, 0.0237310,
                                   0.0401683, 0.0712559, 0.1264458, 0.2073413, 0.2902366, 0.3445623,
                                   0.3698049, 0.3668534, 0.3106727, 0.2078154, 0.1164354, 0.0616764,
                                   0.0337200, 0.0194023, 0.0117831, 0.0074357, 0.0022732, 0.0008800,
                                   0.0004579, 0.0002345, 0.0001586, 0.0001143, 0.0000710};
static const double thurber_x[] = {-3.067, -2.981, -2.921, -2.912, -2.840, -2.797, -2.702, -2.699,
                                   -2.633, -2.481, -2.363, -2.322, -1.501, -1.460, -1.274, -1.212,
                                   -1.100, -1.046, -0.915, -0.714, -0.566, -0.545, -0.400, -0.309,
                                   -0.109, -0.103, 0.010,  0.119,  0.377,  0.790,  0.963,  1.006,
                                   1.115,  1.572,  1.841,  2.047,  2.200};
static const double thurber_y[] = {
    80.574,   84.248,   87.264,   87.195,   89.076,   89.608,   89.868,   90.101,
    92.405,   95.854,   100.696,  101.060,  401.672,  390.724,  567.534,  635.316,
    733.054,  759.087,  894.206,  990.785,  1090.109, 1080.914, 1122.643, 1178.351,
    1260.531, 1273.514, 1288.339, 1327.543, 1353.863, 1414.509, 1425.208, 1421.384,
    1442.962, 1464.350, 1468.705, 1447.894, 1457.628};

static double saturation(double x, const double *b, double *g, const void *context) {
    (void)context;
    double e = exp(-b[1] * x);
    g[0] = -expm1(-b[1] * x);
    g[1] = b[0] * x * e;
    return b[0] * g[0];
}

static double misra1b(double x, const double *b, double *g, const void *context) {
    (void)context;
    double s = 1 + b[1] * x / 2;
    g[0] = 1 - 1 / (s * s);
    g[1] = b[0] * x / (s * s * s);
    return b[0] * g[0];
}

static double misra1c(double x, const double *b, double *g, const void *context) {
    (void)context;
    double s = 1 + 2 * b[1] * x;
    g[0] = 1 - 1 / sqrt(s);
    g[1] = b[0] * x / (s * sqrt(s));
    return b[0] * g[0];
}

static double misra1d(double x, const double *b, double *g, const void *context) {
    (void)context;
    double s = 1 + b[1] * x;
    g[0] = b[1] * x / s;
    g[1] = b[0] * x / (s * s);
    return b[0] * g[0];
}

static double two_decays(double x, const double *b, double *g, const void *context) {
    (void)context;
    g[0] = 1;
    g[1] = exp(-x * b[3]);
    g[2] = exp(-x * b[4]);
    g[3] = -x * b[1] * g[1];
    g[4] = -x * b[2] * g[2];
    return b[0] + b[1] * g[1] + b[2] * g[2];
}

static double three_decays(double x, const double *b, double *g, const void *context) {
    (void)context;
    double sum = 0;
    for (size_t k = 0; k < 6; k += 2) {
        g[k] = exp(-b[k + 1] * x);
        g[k + 1] = -x * b[k] * g[k];
        sum += b[k] * g[k];
    }
    return sum;
}

static double peak(double x, const double *b, double *g, const void *context) {
    (void)context;
    double z = (x - b[2]) / b[1], e = exp(-0.5 * z * z);
    g[0] = e / b[1];
    g[1] = b[0] / (b[1] * b[1]) * e * (z * z - 1);
    g[2] = b[0] / (b[1] * b[1]) * e * z;
    return b[0] * g[0];
}

static double rational(double x, const double *b, double *g, const void *context) {
    (void)context;
    double top = b[0] + x * (b[1] + x * (b[2] + x * b[3]));
    double bottom = 1 + x * (b[4] + x * (b[5] + x * b[6])), power = 1;
    for (size_t k = 0; k < 4; k++) {
        g[k] = power / bottom;
        if (k > 0) {
            g[3 + k] = -top * power / (bottom * bottom);
        }
        power *= x;
    }
    return top / bottom;
}

#define DATA(name) name##_x, name##_y
#define POINTS(name) (sizeof name##_x / sizeof *name##_x)

/* clang-format off */
static const struct problem problems[] = {
    {"Misra1a", saturation, POINTS(misra), 2, {{500, 0.0001}, {250, 0.0005}},
     {2.3894212918E+02, 5.5015643181E-04}, {2.7070075241E+00, 7.2668688436E-06},
     1.2455138894E-01, DATA(misra)},
    {"Misra1b", misra1b, POINTS(misra), 2, {{500, 0.0001}, {300, 0.0002}},
     {3.3799746163E+02, 3.9039091287E-04}, {3.1643950207E+00, 4.2547321834E-06},
     7.5464681533E-02, DATA(misra)},
    {"Misra1c", misra1c, POINTS(misra), 2, {{500, 0.0001}, {600, 0.0002}},
     {6.3642725809E+02, 2.0813627256E-04}, {4.6638326572E+00, 1.7728423155E-06},
     4.0966836971E-02, DATA(misra)},
    {"Misra1d", misra1d, POINTS(misra), 2, {{500, 0.0001}, {450, 0.0003}},
     {4.3736970754E+02, 3.0227324449E-04}, {3.6489174345E+00, 2.9334354479E-06},
     5.6419295283E-02, DATA(misra)},
    {"BoxBOD", saturation, POINTS(box), 2, {{1, 1}, {100, 0.75}},
     {2.1380940889E+02, 5.4723748542E-01}, {1.2354515176E+01, 1.0455993237E-01},
     1.1680088766E+03, DATA(box)},
    {"MGH17", two_decays, POINTS(mgh17), 5, {{50, 150, -100, 1, 2}, {0.5, 1.5, -1, 0.01, 0.02}},
     {3.7541005211E-01, 1.9358469127E+00, -1.4646871366E+00, 1.2867534640E-02, 2.2122699662E-02},
     {2.0723153551E-03, 2.2031669222E-01, 2.2175707739E-01, 4.4861358114E-04, 8.9471996575E-04},
     5.4648946975E-05, DATA(mgh17)},
    {"Lanczos3", three_decays, POINTS(lanczos), 6,
     {{1.2, 0.3, 5.6, 5.5, 6.5, 7.6}, {0.5, 0.7, 3.6, 4.2, 4, 6.3}},
     {8.6816414977E-02, 9.5498101505E-01, 8.4400777463E-01, 2.9515951832E+00, 1.5825685901E+00,
      4.9863565084E+00},
     {1.7197908859E-02, 9.7041624475E-02, 4.1488663282E-02, 1.0766312506E-01, 5.8371576281E-02,
      3.4436403035E-02},
     1.6117193594E-08, DATA(lanczos)},
    {"Eckerle4", peak, POINTS(eckerle), 3, {{1, 10, 500}, {1.5, 5, 450}},
     {1.5543827178E+00, 4.0888321754E+00, 4.5154121844E+02},
     {1.5408051163E-02, 4.6803020753E-02, 4.6800518816E-02}, 1.4635887487E-03, DATA(eckerle)},
    {"Thurber", rational, POINTS(thurber), 7,
     {{1000, 1000, 400, 40, 0.7, 0.3, 0.03}, {1300, 1500, 500, 75, 1, 0.4, 0.05}},
     {1.2881396800E+03, 1.4910792535E+03, 5.8323836877E+02, 7.5416644291E+01, 9.6629502864E-01,
      3.9797285797E-01, 4.9727297349E-02},
     {4.6647963344E+00, 3.9571156086E+01, 2.8698696102E+01, 5.5675370270E+00, 3.1333340687E-02,
      1.4984928198E-02, 6.5842344623E-03},
     5.6427082397E+03, DATA(thurber)},
};
/* clang-format on */
enum { PROBLEMS = sizeof problems / sizeof *problems };

/* At the certified parameters, which are rounded to 11 digits: the sum is stationary there, so the
 * rounding of the parameters enters squared, and what is left is that of the certified sum.
 * Lanczos3 has residuals of 1e-5 of the data: doubles carry its sum to about 1e-16/1e-5 sqrt(24) =
 * 1e-10. */
static void data_and_certified_values_agree(void **state) {
    (void)state;
    for (size_t p = 0; p < PROBLEMS; p++) {
        const struct problem *problem = &problems[p];
        double sum = 0, gradient[RK_LEAST_SQUARES_PARAMS];
        for (size_t i = 0; i < problem->points; i++) {
            double r =
                problem->y[i] - problem->model(problem->x[i], problem->certified, gradient, NULL);
            sum += r * r;
        }
        if (fabs(sum - problem->residual) > 1e-9 * problem->residual) {
            fail_msg("%s: sum of squares %.12g, certified %.11g", problem->name, sum,
                     problem->residual);
        }
    }
}

/* 8 digits of the parameters and of the sum, from both starts; 6 of the standard deviations, which
 * come from differences of large numbers in the harder problems. */
static void certified_values_from_both_starts(void **state) {
    (void)state;
    for (size_t p = 0; p < PROBLEMS; p++) {
        const struct problem *problem = &problems[p];
        for (int start = 0; start < 2; start++) {
            struct rk_least_squares task = {.model = problem->model,
                                            .x = problem->x,
                                            .y = problem->y,
                                            .points = problem->points,
                                            .params = problem->params};
            struct rk_least_squares_fit fit = {0};
            for (size_t k = 0; k < problem->params; k++) {
                fit.theta[k] = problem->start[start][k];
            }
            struct rk_error err = RK_NO_ERROR;
            if (rk_least_squares_solve(&task, &fit, &err) != RK_OK) {
                fail_msg("%s, start %d: %s", problem->name, start + 1, err.message);
            }
            double degrees = (double)(problem->points - problem->params);
            assert_true(fabs(fit.residual - problem->residual) < 1e-8 * problem->residual);
            for (size_t k = 0; k < problem->params; k++) {
                double off = fabs(fit.theta[k] / problem->certified[k] - 1);
                double deviation = sqrt(fit.inverse[k][k] * fit.residual / degrees);
                if (off > 1e-8 || fabs(deviation / problem->deviation[k] - 1) > 1e-6) {
                    fail_msg("%s, start %d: b%zu = %.12g +- %.12g, certified %.11g +- %.11g",
                             problem->name, start + 1, k + 1, fit.theta[k], deviation,
                             problem->certified[k], problem->deviation[k]);
                }
            }
        }
    }
}

static void what_cannot_be_solved_is_refused(void **state) {
    (void)state;
    struct rk_least_squares task = {
        .model = two_decays, .x = box_x, .y = box_y, .points = 4, .params = 5};
    struct rk_least_squares_fit fit = {0};
    struct rk_error err = RK_NO_ERROR;
    assert_int_equal(rk_least_squares_solve(&task, &fit, &err), RK_EINVALID);
    task.params = RK_LEAST_SQUARES_PARAMS + 1;
    task.points = MOST;
    assert_int_equal(rk_least_squares_solve(&task, &fit, &err), RK_EINVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(data_and_certified_values_agree),
        cmocka_unit_test(certified_values_from_both_starts),
        cmocka_unit_test(what_cannot_be_solved_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
