/* A report as files: tables, JSON, gnuplot scripts and pictures. */
#include "ensemble/analysis_private.h"
#include "ensemble/plot.h"
#include "ensemble/report.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* What a file is written from; `write` knows which of the members it needs. */
struct page {
    const struct rk_report *report;
    const struct rk_report_entry *entry;
    const struct rk_result *result;
    const struct rk_picture *picture;
    void (*write)(const struct page *page, FILE *out);
};

static void write_summary(const struct page *page, FILE *out) {
    rk_outcomes_write_csv(page->entry->outcomes, page->report->plan->study->point_count, out);
}

static void write_columns(const struct page *page, FILE *out) {
    rk_result_write_csv(page->result, out);
}

static void write_json(const struct page *page, FILE *out) {
    rk_report_entry_json(page->report, page->entry, out);
}

static void write_script(const struct page *page, FILE *out) {
    const struct rk_analysis_methods *methods = page->entry->request->analysis->methods;
    rk_plot_begin(page->picture, methods->panels, out);
    methods->picture(page->picture, out);
}

/* Write to a temporary name, then rename: a reader sees the old file or the new one. */
static enum rk_status write_file(const char *folder, const char *name, const struct page *page,
                                 struct rk_error *err) {
    char *path = NULL, *temporary = NULL;
    if (asprintf(&path, "%s/%s", folder, name) < 0 ||
        asprintf(&temporary, "%s/.%s.%ld", folder, name, (long)getpid()) < 0) {
        free(path);
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = RK_OK;
    FILE *out = fopen(temporary, "we");
    bool good = out != NULL;
    if (out) {
        page->write(page, out);
        good = fflush(out) == 0 && !ferror(out);
        good = fclose(out) == 0 && good;
    }
    if (!good || rename(temporary, path) != 0) {
        status = rk_fail(err, RK_EIO, "cannot be written: %s", strerror(errno));
        rk_error_locate(err, "%s", path);
        unlink(temporary);
    }
    free(path);
    free(temporary);
    return status;
}

static void say(const struct rk_notice *notice, const char *line) {
    if (notice && notice->say) {
        notice->say(notice->context, line);
    }
}

static enum rk_status draw(const struct page *page, const char *folder,
                           const struct rk_notice *notice, struct rk_error *err) {
    char script[RK_NAME + 8];
    struct rk_error trouble = RK_NO_ERROR;
    snprintf(script, sizeof script, "%s.gp", page->entry->label);
    enum rk_status status = write_file(folder, script, page, err);
    if (status == RK_OK && rk_plot_run(folder, script, &trouble) != RK_OK) {
        say(notice, trouble.message);
    }
    return status;
}

static enum rk_status draw_entry(struct page *page, const char *folder,
                                 const struct rk_notice *notice, struct rk_error *err) {
    const struct rk_study *study = page->report->plan->study;
    struct rk_panel panels[RK_PANELS_MAX];
    char files[RK_PANELS_MAX][3 * RK_NAME];
    char title[256];
    size_t count = 0, all = 0;
    for (size_t p = 0; p < study->point_count; p++) {
        const struct rk_outcome *o = &page->entry->outcomes[p];
        bool drawn = rk_result_rows(&o->result) > 0;
        all += drawn;
        if (drawn && count < RK_PANELS_MAX) {
            snprintf(files[count], sizeof files[count], "%s.%s.csv", page->entry->label, o->point);
            panels[count] = (struct rk_panel){o->point, files[count], &o->result};
            count++;
        }
    }
    if (count == 0) {
        return RK_OK;
    }
    if (count < all) {
        say(notice, "a picture shows the first eight points only; the tables have them all");
    }
    snprintf(title, sizeof title, "%s: %s", study->name,
             page->entry->request->analysis->methods->title);
    struct rk_picture picture = {page->entry->label, title, panels, count};
    page->picture = &picture;
    page->write = write_script;
    return draw(page, folder, notice, err);
}

static enum rk_status write_entry(const struct rk_report *report,
                                  const struct rk_report_entry *entry, const char *folder,
                                  const struct rk_notice *notice, struct rk_error *err) {
    struct page page = {.report = report, .entry = entry, .write = write_summary};
    char name[3 * RK_NAME];
    snprintf(name, sizeof name, "%s.csv", entry->label);
    enum rk_status status = write_file(folder, name, &page, err);
    for (size_t p = 0; p < report->plan->study->point_count && status == RK_OK; p++) {
        const struct rk_outcome *o = &entry->outcomes[p];
        if (rk_result_rows(&o->result) > 0) {
            page.write = write_columns;
            page.result = &o->result;
            snprintf(name, sizeof name, "%s.%s.csv", entry->label, o->point);
            status = write_file(folder, name, &page, err);
        }
    }
    if (status == RK_OK) {
        page.write = write_json;
        snprintf(name, sizeof name, "%s.json", entry->label);
        status = write_file(folder, name, &page, err);
    }
    return status == RK_OK ? draw_entry(&page, folder, notice, err) : status;
}

enum rk_status rk_report_write(const struct rk_report *report, const char *folder,
                               const struct rk_notice *notice, struct rk_error *err) {
    char *place;
    if (asprintf(&place, "%s/analysis", folder) < 0) {
        return rk_fail(err, RK_EMEMORY, "out of memory");
    }
    enum rk_status status = RK_OK;
    if (mkdir(place, 0777) != 0 && errno != EEXIST) {
        status = rk_fail(err, RK_EIO, "cannot be made: %s", strerror(errno));
        rk_error_locate(err, "%s", place);
    }
    for (size_t i = 0; i < report->count && status == RK_OK; i++) {
        status = write_entry(report, &report->entries[i], place, notice, err);
    }
    free(place);
    return status;
}
