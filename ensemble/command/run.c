/* reckon run: carry out what is missing of a study. */
#include "ensemble/analysis/target.h"
#include "ensemble/command/command.h"
#include "ensemble/command/outlook.h"
#include "ensemble/command/progress.h"
#include "ensemble/runner.h"
#include "ensemble/runner/ranks.h"
#include "ensemble/store.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { REASONS_SHOWN = 5 };

struct run_options {
    const char *output, *shard;
    uint64_t threads;
    double checkpoint;
    bool quiet, retry_failed;
};

static const struct rk_option options[] = {
    {.name = "output",
     .letter = 'o',
     .type = RK_OPTION_TEXT,
     .offset = offsetof(struct run_options, output),
     .argument = "DIR",
     .doc = "the study's folder, made if need be (default: the study's name)"},
    {.name = "threads",
     .letter = 'j',
     .type = RK_OPTION_COUNT,
     .offset = offsetof(struct run_options, threads),
     .argument = "N",
     .low = 1,
     .high = 4096,
     .doc =
         "replicas at a time, and cores unless run.threads is a number [all]; changes no result"},
    {.name = "shard",
     .type = RK_OPTION_TEXT,
     .offset = offsetof(struct run_options, shard),
     .argument = "I/N",
     .doc = "only the I-th of N parts of the plan, as a task of a job array"},
    {.name = "checkpoint",
     .type = RK_OPTION_REAL,
     .offset = offsetof(struct run_options, checkpoint),
     .argument = "SECONDS",
     .fallback = "30",
     .low = 0,
     .high = 1e6,
     .doc = "time between two checkpoints of a replica; changes no result"},
    {.name = "retry-failed",
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct run_options, retry_failed),
     .doc = "replicas that failed are done again, as they were"},
    {.name = "quiet",
     .letter = 'q',
     .type = RK_OPTION_FLAG,
     .offset = offsetof(struct run_options, quiet),
     .doc = "no progress and no summary, only what goes wrong"},
};

/* Signals reach a program through a global or not at all. An atomic one, since the handler may run
 * in any thread and all of them ask; a handler may use it as it has no lock. */
static atomic_int stop_wanted;
_Static_assert(ATOMIC_INT_LOCK_FREE == 2, "a signal handler needs an atomic without a lock");

static void on_signal(int number) {
    (void)number;
    static const char text[] = "\nstopping: what runs is being kept (once more to end at once)\n";
    atomic_store(&stop_wanted, 1);
    ssize_t ignored = write(STDERR_FILENO, text, sizeof text - 1);
    (void)ignored;
}

/* The first signal asks, a second one ends the program: no result can be hurt by that. A full disk
 * or a quota is an error of a write, not a signal. */
static void catch_signals(void) {
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* A terminal that is closed asks too, unless nohup or a shell has had that ignored. */
    struct sigaction before;
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN) {
        sigaction(SIGHUP, &action, NULL);
    }
    signal(SIGXFSZ, SIG_IGN);
}

static bool stop(void *context) {
    (void)context;
    return atomic_load(&stop_wanted) != 0;
}

/* `context` is a bool: is there a progress line? */
static void message(void *context, const char *line) {
    if (*(const bool *)context) {
        rk_progress_clear();
    }
    rk_warn("%s", line);
}

static void progress(void *context, const struct rk_progress *p) {
    (void)context;
    rk_progress_draw(p);
}

static void list_reasons(const char *folder, const struct rk_plan *plan, size_t failed) {
    size_t shown = 0;
    for (size_t i = 0; i < plan->count && shown < REASONS_SHOWN && shown < failed; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        if (facts.state == RK_RUN_FAILED) {
            rk_warn("run %s failed: %s", plan->runs[i].id, facts.reason);
            shown++;
        }
    }
    if (failed > shown) {
        rk_warn("%zu more failed; 'reckon status %s' lists them", failed - shown, folder);
    }
}

/* Runs that ended in that state after being tried again. */
static size_t count_retried(const char *folder, const struct rk_plan *plan,
                            enum rk_run_state state) {
    size_t retried = 0;
    for (size_t i = 0; i < plan->count && plan->study->retry.times > 0; i++) {
        struct rk_run_facts facts = rk_store_run_facts(folder, plan, &plan->runs[i]);
        retried += facts.state == state && facts.retries > 0;
    }
    return retried;
}

static void say_next(const char *folder, const struct rk_plan *plan,
                     const struct rk_run_report *report, const struct run_options *o) {
    size_t retried = count_retried(folder, plan, RK_RUN_DONE);
    size_t again = count_retried(folder, plan, RK_RUN_FAILED);
    if (retried > 0) {
        printf("%zu run%s done with smaller time steps after failing\n", retried,
               retried == 1 ? " was" : "s were");
    }
    if (again > 0) {
        printf("%zu run%s failed with smaller time steps, too\n", again, again == 1 ? "" : "s");
    }
    if (report->failed > 0 && plan->study->retry.times == 0) {
        printf("next: with 'retry: {step: 0.5, times: 1}' in the study failed runs are done again "
               "with half the time step\n");
    }
    if (report->done > 0 && !o->shard) {
        printf("next: reckon analyze %s\n", folder);
    }
}

static int summarise(const char *folder, const struct rk_plan *plan,
                     const struct rk_run_report *report, const struct run_options *o) {
    bool quiet = o->quiet;
    if (!quiet) {
        printf("%s: %zu of %zu runs%s%s done, %zu failed, %zu missing\n", folder, report->done,
               report->runs, o->shard ? " of shard " : "", o->shard ? o->shard : "", report->failed,
               report->missing);
    }
    list_reasons(folder, plan, report->failed);
    if (report->missing > 0) {
        if (!quiet) {
            printf("next: the same command again goes on from here\n");
        }
        return RK_EXIT_INTERRUPTED;
    }
    if (!quiet) {
        say_next(folder, plan, report, o);
    }
    return report->failed > 0 ? RK_EXIT_REPLICAS : RK_EXIT_DONE;
}

/* "2/8" as the second of eight. */
static enum rk_status read_shard(const char *text, struct rk_runner_options *runner,
                                 struct rk_error *err) {
    char *rest;
    if (!text) {
        return RK_OK;
    }
    errno = 0;
    unsigned long long shard = strtoull(text, &rest, 10);
    unsigned long long shards = *rest == '/' ? strtoull(rest + 1, &rest, 10) : 0;
    if (strspn(text, "0123456789/") != strlen(text) || *rest != '\0' || errno != 0 || shard < 1 ||
        shard > shards || shards > RK_RUNS_MAX) {
        return rk_fail(err, RK_EINVALID,
                       "--shard: '%.64s' will not do, it must be like 2/8, the second of eight "
                       "parts",
                       text);
    }
    runner->shard = shard;
    runner->shards = shards;
    return RK_OK;
}

static int run_plan(const char *folder, const struct rk_plan *plan, const struct run_options *o,
                    struct rk_ranks *ranks, bool *met) {
    struct rk_store *store = NULL;
    struct rk_error err = RK_NO_ERROR;
    struct rk_run_report report = {0};
    bool led = rk_ranks_number(ranks) > 0; /* what is to be said is said by rank 0 */
    bool shows = !o->quiet && !led && rk_shows_progress();
    /* Under mpirun there is a process a core, or it is told how many threads each may have. */
    struct rk_runner_options runner = {.threads = ranks && o->threads == 0 ? 1 : (int)o->threads,
                                       .ranks = ranks,
                                       .retry_failed = o->retry_failed,
                                       .checkpoint_every = o->checkpoint,
                                       .stop = stop,
                                       .progress = shows ? progress : NULL,
                                       .message = message,
                                       .context = &shows};
    catch_signals();
    if (read_shard(o->shard, &runner, &err) != RK_OK ||
        rk_store_open(folder, plan, &store, &err) != RK_OK) {
        return rk_complain(&err);
    }
    if (!led && rk_store_mended(store)) {
        rk_warn("'%s/plan.h5' was missing or damaged and is written again", folder);
    }
    char words[256];
    if (!led && o->threads > 0 && rk_outlook_crowded(plan->study, (int)o->threads, words)) {
        rk_warn("%s", words);
    }
    size_t surplus = led ? 0 : rk_store_surplus(folder, plan);
    if (surplus > 0) {
        rk_warn("'%s' holds %zu finished run%s beyond what the study asks for now; "
                "kept, but not counted",
                folder, surplus, surplus == 1 ? "" : "s");
    }
    enum rk_status status = rk_runner_run(plan, store, &runner, &report, &err);
    rk_store_close(store);
    *met = status != RK_EMEMORY;
    if (shows) {
        rk_progress_clear();
    }
    if (led && status != RK_EIO) {
        return RK_EXIT_DONE;
    }
    if (status == RK_OK || status == RK_EINTERRUPTED) {
        return summarise(folder, plan, &report, o);
    }
    list_reasons(folder, plan, report.failed);
    rk_complain(&err);
    return RK_EXIT_FAILED;
}

/* As one of several ranks, if mpirun or the like started this program. */
static int run_ranked(const char *folder, const struct rk_plan *plan, const struct run_options *o,
                      bool *leads) {
    struct rk_ranks *ranks = NULL;
    struct rk_error err = RK_NO_ERROR;
    *leads = false;
    if (rk_ranks_wanted() && rk_ranks_join(&ranks, &err) != RK_OK) {
        return rk_complain(&err);
    }
    /* A rank that never met the others ends without leave, and mpirun ends them. */
    bool met = false;
    *leads = rk_ranks_number(ranks) == 0;
    int code = run_plan(folder, plan, o, ranks, &met);
    if (met) {
        rk_ranks_leave(ranks);
    }
    return code;
}

/* A shard or a rank knows of its own part only: the rest of a study with a precision target is
 * another call's. */
static void say_rest(const struct rk_study *study, bool more) {
    bool decided = true;
    for (size_t p = 0; p < study->point_count; p++) {
        decided = decided && study->points[p].replicas > 0;
    }
    if (!decided) {
        printf("next: until decides on more replicas when the pilot is whole; call all parts once "
               "more then\n");
    } else if (more) {
        printf("next: until asks for more replicas; call all parts once more\n");
    }
}

/* Once, or twice for a study with a precision target: its pilot, and what that showed to be needed.
 * Ranks meet only once in a program, and a shard of the pilot may be done before the others are:
 * then the second part is another call's. */
static int run_to_target(const char *folder, struct rk_study *study, const struct run_options *o) {
    struct rk_error err = RK_NO_ERROR;
    const bool part = rk_ranks_wanted() || o->shard;
    struct run_options now = *o;
    int code = RK_EXIT_DONE;
    for (bool more = true; more; now.retry_failed = false) { /* once is what was asked for */
        struct rk_plan *plan = NULL;
        bool known;
        if (rk_target_settle(folder, study, &known, &err) != RK_OK ||
            rk_plan_create(study, &plan, &err) != RK_OK) {
            return rk_complain(&err);
        }
        bool leads;
        code = run_ranked(folder, plan, &now, &leads);
        rk_plan_free(plan);
        more = code == RK_EXIT_DONE || code == RK_EXIT_REPLICAS;
        if (more && rk_target_settle(folder, study, &more, &err) != RK_OK) {
            return rk_complain(&err);
        }
        if (part && leads && study->until.request && !o->quiet) {
            say_rest(study, more);
        }
        if (leads && !more && !o->quiet && (code == RK_EXIT_DONE || code == RK_EXIT_REPLICAS)) {
            rk_target_print_capped(study, stdout);
        }
        more = more && !rk_ranks_wanted();
    }
    return code;
}

static int run_main(const void *values, size_t count, char *const *operands) {
    (void)count;
    const struct run_options *o = values;
    struct rk_study *study = NULL;
    int code = rk_command_load_study(operands[0], &study);
    if (code != RK_EXIT_DONE) {
        return code;
    }
    const char *folder = o->output ? o->output : study->name;
    /* Of ranks each would say it. */
    for (size_t i = 0; i < study->doubt_count && !rk_ranks_wanted(); i++) {
        rk_warn("%s: %s", study->doubts[i].where, study->doubts[i].message);
    }
    code = run_to_target(folder, study, o);
    rk_study_free(study);
    return code;
}

const struct rk_command rk_command_run = {
    .name = "run",
    .summary = "carry out a study: start it, resume it, extend it",
    .usage = "STUDY [-o DIR] [--shard I/N]",
    .about = "Carries out the replicas that are missing in the study's folder, one a core, the\n"
             "longest first; cores that have none help with large ones. Ctrl-C keeps what is\n"
             "done and lets running replicas write a checkpoint; the same command goes on from\n"
             "there, also after a power cut, with the same bytes in the end. More replicas in\n"
             "the study file are added to those there.\n"
             "Replicas that went wrong stay failed, unless the study has 'retry' ({step: 0.5,\n"
             "times: 2}: again with half the time step, and a quarter) or --retry-failed is given\n"
             "(again as they were, after a mended program).\n"
             "Several may run in one folder, on one machine or many: under mpirun, as shards, or\n"
             "just started twice. Each replica is done by one of them.\n"
             "Exit codes: 0 all done, 3 some replicas failed, 130 stopped, 1 an error of the disk.",
    .options = options,
    .option_count = sizeof options / sizeof *options,
    .size = sizeof(struct run_options),
    .operands_min = 1,
    .operands_max = 1,
    .example = "reckon run cases/bne/quickstart.yaml -o out --threads 2",
    .main = run_main,
};
