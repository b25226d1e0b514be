#include "ensemble/store/seal.h"
#include "ensemble/store/files.h"

#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

/* As it lies in the file, in the machine's byte order: a file from a machine of the other order
 * has another magic number and counts as not ours. */
struct block {
    uint64_t magic;
    struct rk_origin origin;
    char filler[3]; /* so that nothing below is padded */
    uint32_t state;
    uint64_t steps;
    char reason[512];
    uint64_t length; /* of the whole file */
    uint64_t sum;    /* of what follows the block */
    uint64_t retries;
    double step;
    char spare[RK_SEAL_SIZE - 720];
    uint64_t self; /* sum of this block up to here */
};
_Static_assert(sizeof(struct block) == RK_SEAL_SIZE, "the seal fills its block");

/* "Rkssele" and the number of the layout. A change of the block above, or of what a file with this
 * seal holds, asks for the next number; where the magic number and the sum stand never changes. */
static const uint64_t magic = 0x32656c6573736b52; /* "Rkssele2" */

/* Sealed by a version with another layout? A bit that was flipped in the number spoils the sum. */
static bool of_another_version(const struct block *block) {
    const uint64_t name = UINT64_MAX >> 8;
    return block->magic != magic && (block->magic & name) == (magic & name) &&
           block->self == XXH64(block, offsetof(struct block, self), 0);
}

bool rk_seal_fits(const struct rk_seal *seal, const struct rk_study *study) {
    return seal->retries == 0 || (seal->retries <= study->retry.times &&
                                  seal->step == rk_retry_step(&study->retry, seal->retries));
}

bool rk_seal_is_last(const struct rk_seal *seal, const struct rk_study *study) {
    bool again = seal->state == RK_SEAL_FAILED && seal->retries < study->retry.times;
    return rk_seal_fits(seal, study) && !again;
}

static enum rk_status sum_of_rest(int file, const char *path, uint64_t *sum, uint64_t *length,
                                  struct rk_error *err) {
    enum { PIECE = 1 << 18 };
    XXH64_state_t *hash = XXH64_createState();
    char *piece = malloc(PIECE);
    if (!hash || !piece) {
        XXH64_freeState(hash);
        free(piece);
        return rk_fail(err, RK_EMEMORY, "not enough memory to check '%s'", path);
    }
    enum rk_status status = RK_OK;
    off_t at = RK_SEAL_SIZE;
    XXH64_reset(hash, 0);
    for (;;) {
        ssize_t count = pread(file, piece, PIECE, at);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count < 0) {
            status = rk_fail_system(err, "read", path);
        }
        if (count <= 0) {
            break;
        }
        XXH64_update(hash, piece, (size_t)count);
        at += count;
    }
    *sum = XXH64_digest(hash);
    *length = (uint64_t)at;
    XXH64_freeState(hash);
    free(piece);
    return status;
}

enum rk_status rk_seal_write(const char *path, const struct rk_seal *seal, struct rk_error *err) {
    int file = open(path, O_RDWR | O_CLOEXEC);
    if (file < 0) {
        return rk_fail_system(err, "open", path);
    }
    struct block block;
    memset(&block, 0, sizeof block);
    block.magic = magic;
    block.origin = seal->origin;
    block.state = (uint32_t)seal->state;
    block.steps = seal->steps;
    block.retries = seal->retries;
    block.step = seal->step;
    memcpy(block.reason, seal->reason, strnlen(seal->reason, sizeof block.reason - 1));
    enum rk_status status = sum_of_rest(file, path, &block.sum, &block.length, err);
    block.self = XXH64(&block, offsetof(struct block, self), 0);
    if (status == RK_OK) {
        status = rk_file_write(file, &block, sizeof block, path, err);
    }
    if (close(file) != 0 && status == RK_OK) {
        status = rk_fail_system(err, "write", path);
    }
    return status;
}

static enum rk_status damaged(struct rk_error *err, const char *path, const char *how) {
    return rk_fail(err, RK_EFORMAT, "'%s' is damaged: %s", path, how);
}

static enum rk_status read_block(int file, const char *path, struct block *block,
                                 struct rk_error *err) {
    struct stat facts;
    if (fstat(file, &facts) != 0) {
        return rk_fail_system(err, "read", path);
    }
    ssize_t count = pread(file, block, sizeof *block, 0);
    if (count < 0) {
        return rk_fail_system(err, "read", path);
    }
    if (count != (ssize_t)sizeof *block) {
        return damaged(err, path, "it ends within its first kilobyte");
    }
    if (of_another_version(block)) {
        return rk_fail(err, RK_EVERSION,
                       "'%s' was written by another version of reckon, whose files are laid out "
                       "differently; read it with that version, or choose another folder with -o",
                       path);
    }
    if (block->magic != magic) {
        return rk_fail(err, RK_EFORMAT, "'%s' is not a file that reckon wrote", path);
    }
    if (block->self != XXH64(block, offsetof(struct block, self), 0)) {
        return damaged(err, path, "its first kilobyte does not have its checksum");
    }
    if ((block->state != RK_SEAL_DONE && block->state != RK_SEAL_FAILED) ||
        !memchr(block->reason, 0, sizeof block->reason) ||
        !memchr(block->origin.identity, 0, sizeof block->origin.identity) ||
        !memchr(block->origin.run, 0, sizeof block->origin.run) ||
        block->retries > RK_RETRIES_MAX) {
        return damaged(err, path, "its first kilobyte says what cannot be");
    }
    if (block->length != (uint64_t)facts.st_size) {
        return rk_fail(err, RK_EFORMAT, "'%s' is damaged: it has %lld bytes, %llu were written",
                       path, (long long)facts.st_size, (unsigned long long)block->length);
    }
    return RK_OK;
}

static enum rk_status read_seal(const char *path, bool whole, struct rk_seal *seal,
                                struct rk_error *err) {
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) {
        return rk_fail_system(err, "open", path);
    }
    struct block block;
    enum rk_status status = read_block(file, path, &block, err);
    if (status == RK_OK && whole) {
        uint64_t sum = 0, length = 0;
        status = sum_of_rest(file, path, &sum, &length, err);
        if (status == RK_OK && (sum != block.sum || length != block.length)) {
            status = damaged(err, path, "its contents do not have their checksum");
        }
    }
    close(file);
    if (status == RK_OK) {
        *seal = (struct rk_seal){.origin = block.origin,
                                 .state = (enum rk_seal_state)block.state,
                                 .steps = block.steps,
                                 .retries = block.retries,
                                 .step = block.step};
        memcpy(seal->reason, block.reason, sizeof seal->reason);
    }
    return status;
}

enum rk_status rk_seal_read(const char *path, struct rk_seal *seal, struct rk_error *err) {
    return read_seal(path, false, seal, err);
}

enum rk_status rk_seal_verify(const char *path, struct rk_seal *seal, struct rk_error *err) {
    return read_seal(path, true, seal, err);
}
