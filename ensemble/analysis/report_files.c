/* A report as files: tables, JSON, gnuplot scripts and pictures. */
#include "ensemble/analysis/plot.h"
#include "ensemble/analysis/private.h"
#include "ensemble/analysis/report.h"
#include "ensemble/analysis/written.h"
#include "ensemble/store/files.h"

#include <ctype.h>
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
    void (*draw)(const struct rk_picture *picture, FILE *out); /* commands of a script */
    bool panels;
    void (*write)(const struct page *page, FILE *out);
    FILE *names; /* of the files that were written, a line each; NULL: nobody asks */
};

static void note_name(const struct page *page, const char *name, const char *ending) {
    if (page->names) {
        fprintf(page->names, "%s%s\n", name, ending);
    }
}

static void write_summary(const struct page *page, FILE *out) {
    rk_outcomes_write_csv(page->entry->outcomes, page->entry->outcome_count, out);
}

static void write_columns(const struct page *page, FILE *out) {
    rk_result_write_csv(page->result, out);
}

static void write_json(const struct page *page, FILE *out) {
    rk_report_entry_json(page->report, page->entry, out);
}

static void write_script(const struct page *page, FILE *out) {
    rk_plot_begin(page->picture, page->panels, out);
    page->draw(page->picture, out);
}

/* A reader sees the old file or the new one, never half of one. */
static enum rk_status write_file(const char *folder, const char *name, const struct page *page,
                                 struct rk_error *err) {
    struct rk_path path;
    char *text = NULL;
    size_t size = 0;
    enum rk_status status = rk_path_set(&path, err, "%s/%s", folder, name);
    FILE *out = status == RK_OK ? open_memstream(&text, &size) : NULL;
    if (status != RK_OK) {
        return status;
    }
    bool good = out != NULL;
    if (out) {
        page->write(page, out);
        good = !ferror(out);
        good = fclose(out) == 0 && good;
    }
    status = good ? rk_file_replace(path.text, text, size, err)
                  : rk_fail(err, RK_EMEMORY, "out of memory");
    free(text);
    note_name(page, name, "");
    return status;
}

static enum rk_status draw(struct page page, const struct rk_picture *picture, const char *folder,
                           const struct rk_notice *notice, struct rk_error *err) {
    char script[RK_NAME + 8];
    struct rk_error trouble = RK_NO_ERROR;
    page.picture = picture;
    page.write = write_script;
    snprintf(script, sizeof script, "%s.gp", picture->name);
    enum rk_status status = write_file(folder, script, &page, err);
    if (status == RK_OK && rk_plot_run(folder, script, &trouble) != RK_OK) {
        rk_notice_say(notice, "%s", trouble.message);
    }
    note_name(&page, picture->name, ".png");
    return status;
}

static enum rk_status draw_entry(const struct page *page, const char *folder,
                                 const struct rk_notice *notice, struct rk_error *err) {
    const struct rk_study *study = page->report->plan->study;
    struct rk_panel panels[RK_PANELS_MAX];
    char files[RK_PANELS_MAX][3 * RK_NAME];
    char title[256];
    size_t count = 0, all = 0;
    for (size_t p = 0; p < page->entry->outcome_count; p++) {
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
        rk_notice_say(notice,
                      "%s.png shows the first %d of %zu points only; the tables have them all",
                      page->entry->label, (int)RK_PANELS_MAX, all);
    }
    snprintf(title, sizeof title, "%s: %s", study->name,
             page->entry->request->analysis->methods->title);
    struct rk_picture picture = {page->entry->label, title, NULL, panels, count};
    return draw(*page, &picture, folder, notice, err);
}

static enum rk_status write_entry(const struct rk_report *report,
                                  const struct rk_report_entry *entry, const char *folder,
                                  const struct rk_notice *notice, FILE *names,
                                  struct rk_error *err) {
    const struct rk_analysis_methods *methods = entry->request->analysis->methods;
    struct page page = {.report = report,
                        .entry = entry,
                        .draw = methods->picture,
                        .panels = methods->panels,
                        .write = write_summary,
                        .names = names};
    char name[3 * RK_NAME];
    snprintf(name, sizeof name, "%s.csv", entry->label);
    enum rk_status status = write_file(folder, name, &page, err);
    for (size_t p = 0; p < entry->outcome_count && status == RK_OK; p++) {
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
    struct rk_path place;
    char *text = NULL;
    size_t size = 0;
    enum rk_status status = rk_path_set(&place, err, "%s/analysis", folder);
    if (status == RK_OK) {
        status = rk_folder_make(place.text, err);
    }
    FILE *names = status == RK_OK ? open_memstream(&text, &size) : NULL;
    if (status == RK_OK && !names) {
        status = rk_fail(err, RK_EMEMORY, "out of memory");
    }
    for (size_t i = 0; i < report->count && status == RK_OK; i++) {
        status = write_entry(report, &report->entries[i], place.text, notice, names, err);
    }
    bool listed = names && !ferror(names);
    listed = names && fclose(names) == 0 && listed;
    if (names && !listed && status == RK_OK) {
        status = rk_fail(err, RK_EMEMORY, "out of memory");
    }
    if (status == RK_OK) {
        status = rk_written_settle(place.text, text, notice, err);
    }
    free(text);
    return status;
}

/* A picture may be missing: then gnuplot was, and that has been said. */
void rk_report_print_files(const struct rk_report *report, const char *folder, FILE *out) {
    static const char *const kinds[] = {"png", "csv", "json"};
    static const char *const names[] = {"pictures", "tables", "JSON"};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        const char *name = names[k];
        for (size_t i = 0; i < report->count; i++) {
            struct rk_path file;
            if (rk_path_set(&file, NULL, "%s/analysis/%s.%s", folder, report->entries[i].label,
                            kinds[k]) == RK_OK &&
                access(file.text, R_OK) == 0) {
                fprintf(out, "%-9s %s\n", name, file.text);
                name = "";
            }
        }
    }
    fprintf(out, "%-9s %s/study.h5 (all of it), %s/analysis/*.POINT.csv (what the pictures show)\n",
            "", folder, folder);
}

/* "folder/name.png" in its parts. The name goes into a script: harmless characters only. */
static enum rk_status split_path(const char *path, char folder[4096], char name[RK_NAME],
                                 struct rk_error *err) {
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    size_t length = strlen(base), before = (size_t)(base - path);
    bool good = length > 4 && length - 4 < RK_NAME && before < 4096 &&
                strcmp(base + length - 4, ".png") == 0;
    for (const char *c = base; *c != '\0'; c++) {
        good = good && (unsigned char)*c < 0x80 &&
               (isalnum((unsigned char)*c) || strchr("-_.", *c) != NULL);
    }
    if (!good) {
        return rk_fail(err, RK_EINVALID,
                       "'%.200s' cannot be the name of a picture: it must end in .png and be made "
                       "of letters, digits, '-', '_' and '.'",
                       base);
    }
    snprintf(folder, 4096, "%.*s", slash ? (int)before : 1, slash ? path : ".");
    snprintf(name, RK_NAME, "%.*s", (int)(length - 4), base);
    return RK_OK;
}

static bool is_folder(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

enum rk_status rk_report_plot_check(const char *path, struct rk_error *err) {
    char folder[4096], name[RK_NAME];
    if (is_folder(path)) {
        return rk_fail(err, RK_EINVALID, "'%.200s' is a folder; name the picture in it, '%.200s%s'",
                       path, path, path[strlen(path) - 1] == '/' ? "x.png" : "/x.png");
    }
    enum rk_status status = split_path(path, folder, name, err);
    if (status == RK_OK && !is_folder(folder)) {
        status = rk_fail(err, RK_EINVALID, "there is no folder '%.200s' to write '%s.png' into",
                         folder, name);
    }
    return status;
}

enum rk_status rk_report_plot_as(const struct rk_picture *model, const char *ending,
                                 void (*draw_it)(const struct rk_picture *picture, FILE *out),
                                 const struct rk_result *result, const char *path,
                                 struct rk_error *err) {
    char folder[4096], base[RK_NAME], name[RK_NAME + 16], table[RK_NAME + 24], script[RK_NAME + 24];
    enum rk_status status = split_path(path, folder, base, err);
    if (status != RK_OK) {
        return status;
    }
    snprintf(name, sizeof name, "%s%s", base, ending);
    snprintf(table, sizeof table, "%s.csv", name);
    snprintf(script, sizeof script, "%s.gp", name);
    const struct rk_panel panel = {base, table, result};
    const struct rk_picture picture = {name, model->title, model->quantity, &panel, 1};
    struct page page = {
        .result = result, .picture = &picture, .draw = draw_it, .write = write_columns};
    status = write_file(folder, table, &page, err);
    if (status == RK_OK) {
        page.write = write_script;
        status = write_file(folder, script, &page, err);
    }
    return status == RK_OK ? rk_plot_run(folder, script, err) : status;
}

enum rk_status rk_report_plot(const struct rk_analysis *analysis, const char *title,
                              const char *quantity, const struct rk_result *result,
                              const char *path, struct rk_error *err) {
    const struct rk_picture model = {.title = title, .quantity = quantity};
    return rk_report_plot_as(&model, "", analysis->methods->picture, result, path, err);
}
