/* What became of precision targets, on the terminal and for machines. */
#include "ensemble/analysis.h"
#include "ensemble/analysis/json.h"
#include "ensemble/analysis/target.h"

#include <math.h>

void rk_target_print_capped(const struct rk_study *study, FILE *out) {
    const struct rk_until *until = &study->until;
    if (until->capped > 0) {
        fprintf(
            out,
            "until: %s of %s is not known to +- %.3g in %zu of %zu point%s: max_replicas, %llu, "
            "is met, and %.0f would be needed\n",
            until->quantity, until->request->analysis->piece.name, until->half_width, until->capped,
            study->point_count, study->point_count == 1 ? "" : "s",
            (unsigned long long)until->max_replicas, until->needed);
    }
}

static void print_point(const char *name, const struct rk_target_outcome *o, double rate,
                        FILE *out) {
    if (!o->target.decided) {
        fprintf(out, "  %s: not decided: %s\n", name, o->target.why);
        return;
    }
    fprintf(out,
            "  %s: %.4g +- %.3g with %zu replicas (%zu of them the pilot), at most %.3g "
            "grain-steps",
            name, o->estimate, o->half_width, o->used, o->target.pilot, o->grain_steps);
    if (isfinite(rate)) {
        fprintf(out, ", %.3g core-seconds", o->grain_steps / rate);
    }
    if (o->missing > 0) {
        fprintf(out, "; %zu more to come", o->missing);
    } else if (o->target.capped) {
        fprintf(out, "; max_replicas was met, %.0f would be needed", o->target.needed);
    }
    fprintf(out, "\n");
}

void rk_target_print(const struct rk_plan *plan, const struct rk_target_outcome *outcomes,
                     double rate, FILE *out) {
    const struct rk_until *until = &plan->study->until;
    if (!outcomes) {
        return;
    }
    fprintf(out, "\nuntil %s of %s is within +- %.3g (%g %%, Stein's two stages)\n",
            until->quantity, until->request->analysis->piece.name, until->half_width,
            100 * until->level);
    for (size_t p = 0; p < plan->study->point_count; p++) {
        print_point(plan->study->points[p].name, &outcomes[p], rate, out);
    }
}

static void write_point(const char *name, const struct rk_target_outcome *o, double rate,
                        struct rk_json *json) {
    rk_json_open_map(json, NULL);
    rk_json_text(json, "point", name);
    rk_json_flag(json, "decided", o->target.decided);
    rk_json_text(json, "why_not", o->target.decided ? NULL : o->target.why);
    rk_json_number(json, "estimate", o->estimate);
    rk_json_number(json, "half_width", o->half_width);
    rk_json_count(json, "pilot", o->target.pilot);
    rk_json_number(json, "deviation", o->target.deviation);
    rk_json_count(json, "replicas", o->target.replicas);
    rk_json_count(json, "used", o->used);
    rk_json_count(json, "missing", o->missing);
    rk_json_flag(json, "max_replicas_met", o->target.capped);
    rk_json_number(json, "grain_steps_at_most", o->grain_steps);
    if (isfinite(rate)) {
        rk_json_number(json, "core_seconds_at_most", o->grain_steps / rate);
    }
    rk_json_close(json);
}

void rk_target_json(const struct rk_plan *plan, const struct rk_target_outcome *outcomes,
                    double rate, struct rk_json *json) {
    const struct rk_until *until = &plan->study->until;
    if (!outcomes) {
        return;
    }
    rk_json_open_map(json, "until");
    rk_json_text(json, "analysis", until->request->analysis->piece.name);
    rk_json_text(json, "quantity", until->quantity);
    rk_json_number(json, "half_width", until->half_width);
    rk_json_number(json, "level", until->level);
    rk_json_count(json, "max_replicas", until->max_replicas);
    rk_json_open_list(json, "points");
    for (size_t p = 0; p < plan->study->point_count; p++) {
        write_point(plan->study->points[p].name, &outcomes[p], rate, json);
    }
    rk_json_close(json);
    rk_json_close(json);
}
