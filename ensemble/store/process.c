#include "ensemble/store/process.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { HOST = 32, BOOT = 13 };

static void host_of(char host[HOST]) {
    char whole[256] = "";
    gethostname(whole, sizeof whole - 1);
    size_t used = 0;
    for (const char *c = whole; *c != '\0' && used < HOST - 1; c++) {
        host[used++] = isalnum((unsigned char)*c) ? *c : '_';
    }
    host[used] = '\0';
}

/* The first line of a file of /proc, "" when there is none. */
static void read_line(const char *path, char *line, int size) {
    FILE *file = fopen(path, "re");
    if (!file || !fgets(line, size, file)) {
        line[0] = '\0';
    }
    if (file) {
        fclose(file);
    }
}

/* The first digits of the kernel's identity of this boot. */
static void boot_of(char boot[BOOT]) {
    char line[64];
    read_line("/proc/sys/kernel/random/boot_id", line, sizeof line);
    size_t used = 0;
    for (const char *c = line; *c != '\0' && used < BOOT - 1; c++) {
        if (isxdigit((unsigned char)*c)) {
            boot[used++] = *c;
        }
    }
    boot[used] = '\0';
}

/* When this process began, in ticks since the boot: the 22nd word of its state, counted from behind
 * its name, which may hold anything. */
static unsigned long long start_of(void) {
    char line[1024];
    read_line("/proc/self/stat", line, sizeof line);
    const char *rest = strrchr(line, ')');
    unsigned long long start = 0;
    int word = 2;
    for (const char *c = rest ? rest + 1 : ""; *c != '\0' && word < 22; c++) {
        if (*c == ' ' && ++word == 22) {
            sscanf(c + 1, "%llu", &start);
        }
    }
    return start;
}

void rk_process_name(char name[RK_PROCESS_NAME]) {
    char host[HOST], boot[BOOT];
    host_of(host);
    boot_of(boot);
    snprintf(name, RK_PROCESS_NAME, "%s-%s-%ld-%llu", host, boot, (long)getpid(), start_of());
}

void rk_process_words(char words[96]) {
    char host[HOST];
    host_of(host);
    snprintf(words, 96, "process %ld on %s", (long)getpid(), host);
}

bool rk_process_is_near(const char *name) {
    char boot[BOOT];
    boot_of(boot);
    const char *dash = strchr(name, '-');
    return boot[0] != '\0' && dash && strncmp(dash + 1, boot, strlen(boot)) == 0 &&
           dash[1 + strlen(boot)] == '-';
}
