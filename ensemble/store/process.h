/* A name for this process that no other has had or will have: host, boot, process, start.
 *
 * Locks of the kernel tell for sure whether a process of the same boot lives; of another boot, or
 * another machine, only its signs of life can tell (worker.h).
 *
 * Threads: no state.
 */
#ifndef RK_ENSEMBLE_STORE_PROCESS_H
#define RK_ENSEMBLE_STORE_PROCESS_H

#include <stdbool.h>

enum { RK_PROCESS_NAME = 80 };

/* "<host>-<boot>-<process id>-<start>", of letters, digits and "-_" only. */
void rk_process_name(char name[RK_PROCESS_NAME]);

/* "process 1234 on host", for people. */
void rk_process_words(char words[96]);

/* Is a name of the boot this process lives in? */
bool rk_process_is_near(const char *name);

#endif
