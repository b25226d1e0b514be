/* A search for inputs that do harm, guided by coverage.
 *
 *     fuzz TARGET [SECONDS [SEED [FOLDER]]]      without arguments: the targets
 *     fuzz TARGET FILE                           one input once more
 *
 * The libraries are built with -fsanitize-coverage=trace-pc (RK_FUZZ), which calls a function at
 * every branch target; here it marks where the run has been. Inputs that reach new places join the
 * pool that mutations begin from. Each input is written to FOLDER/TARGET.last before it is tried:
 * after a crash, or an abort of a sanitizer, that is the one. */
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/targets.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAP = 1 << 16, POOL = 1 << 14, ROOM = 1 << 16 };

static unsigned char here[MAP], ever[MAP]; /* places of this input, of all */

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void) {
    uintptr_t place = (uintptr_t)__builtin_return_address(0);
    here[(place ^ place >> 16) % MAP] = 1;
}

static struct {
    char *bytes[POOL];
    size_t size[POOL], count;
} pool;

static int found_new(void) {
    int new = 0;
    for (size_t k = 0; k < MAP; k++) {
        new += here[k] && !ever[k];
        ever[k] |= here[k];
    }
    return new;
}

static void join(const char *bytes, size_t size) {
    char *copy = pool.count < POOL ? malloc(size + 1) : NULL;
    if (copy) {
        memcpy(copy, bytes, size);
        pool.bytes[pool.count] = copy;
        pool.size[pool.count++] = size;
    }
}

static void attempt(const struct fuzz_target *target, const char *last, const char *bytes,
                    size_t size) {
    char *exact = malloc(size + 1); /* the address sanitizer knows its end */
    FILE *file = last ? fopen(last, "wb") : NULL;
    fuzz_check(exact && (!last || (file && fwrite(bytes, 1, size, file) == size)), "no memory");
    memcpy(exact, bytes, size);
    if (file) {
        fclose(file);
    }
    struct rk_error err = RK_NO_ERROR;
    memset(here, 0, sizeof here);
    enum rk_status status = target->attempt(exact, size, &err);
    fuzz_check(status == RK_OK || err.message[0], "refused without a word");
    free(exact);
}

static void search(const struct fuzz_target *target, double seconds, uint64_t seed,
                   const char *last) {
    static char block[ROOM];
    struct rk_stream stream = rk_stream_of(seed, 0, 0, RK_FOR_TESTS, 0);
    size_t size, tried = 0, seeds = 0;
    for (char *bytes; (bytes = target->seed(seeds, &size)) != NULL; seeds++) {
        attempt(target, last, bytes, size);
        found_new();
        join(bytes, size);
        free(bytes);
    }
    time_t end = time(NULL) + (time_t)seconds;
    while (time(NULL) < end) {
        size_t from = (size_t)(rk_stream_uniform(&stream) * (double)pool.count);
        size = pool.size[from] < ROOM ? pool.size[from] : ROOM;
        memcpy(block, pool.bytes[from], size);
        size = fuzz_mutate(&stream, block, size, ROOM);
        attempt(target, last, block, size);
        tried++;
        if (found_new()) {
            join(block, size);
        }
    }
    size_t places = 0;
    for (size_t k = 0; k < MAP; k++) {
        places += ever[k];
    }
    printf("%s: %zu inputs tried, %zu kept, %zu places reached\n", target->name, tried, pool.count,
           places);
}

static int replay(const struct fuzz_target *target, FILE *file) {
    static char block[ROOM];
    size_t size = fread(block, 1, ROOM, file);
    fclose(file);
    attempt(target, NULL, block, size);
    return 0;
}

int main(int argc, char **argv) {
    const struct fuzz_target *target = NULL;
    for (size_t t = 0; t < fuzz_target_count; t++) {
        if (argc < 2) {
            printf("%-12s %s\n", fuzz_targets[t]->name, fuzz_targets[t]->doc);
        } else if (strcmp(argv[1], fuzz_targets[t]->name) == 0) {
            target = fuzz_targets[t];
        }
    }
    if (!target) {
        return argc < 2 ? 0 : 2;
    }
    FILE *file = argc > 2 ? fopen(argv[2], "rb") : NULL;
    if (file) {
        return replay(target, file);
    }
    char last[256];
    snprintf(last, sizeof last, "%s/%s.last", argc > 4 ? argv[4] : ".", target->name);
    search(target, argc > 2 ? atof(argv[2]) : 60, argc > 3 ? strtoull(argv[3], NULL, 10) : 1, last);
    return 0;
}
