/* Files that programs write: HDF5 of any origin, and the store's own spool, checkpoint and seal. */
#include "ensemble/input/dataset.h"
#include "ensemble/store/checkpoint.h"
#include "ensemble/store/seal.h"
#include "ensemble/store/spool.h"
#include "tests/fuzz/targets.h"

#include <hdf5.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

static const struct rk_origin origin = {.identity = "0123456789abcdef0123456789abcdef",
                                        .run = "base-0001"};

/* All bytes of a file, which is then removed. */
static void *taken(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    fuzz_check(file && fseek(file, 0, SEEK_END) == 0, "a seed cannot be read");
    *size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(*size + 1);
    fuzz_check(bytes && fread(bytes, 1, *size, file) == *size, "a seed cannot be read");
    fclose(file);
    unlink(path);
    return bytes;
}

static const char *temporary(const char *ending) {
    static char path[128];
    const char *folder = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/rk-fuzz-%d%s", folder ? folder : "/tmp", (int)getpid(), ending);
    return path;
}

/* ---- HDF5 --------------------------------------------------------------------------------------
 */

static void add_dataset(hid_t file, const char *name, int rank, hsize_t chunk) {
    const double values[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const hsize_t dims[2] = {3, 4}, line = 12;
    hid_t space = H5Screate_simple(rank, rank == 2 ? dims : &line, NULL);
    hid_t how = H5Pcreate(H5P_DATASET_CREATE);
    if (chunk > 0) {
        H5Pset_chunk(how, 1, &chunk);
        H5Pset_deflate(how, 1);
    }
    hid_t set = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, how, H5P_DEFAULT);
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    H5Dclose(set);
    H5Pclose(how);
    H5Sclose(space);
}

static void *dataset_seed(size_t k, size_t *size) {
    if (k > 0) {
        return NULL;
    }
    const char *path = temporary(".h5");
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    fuzz_check(file >= 0, "no HDF5 file to begin from");
    add_dataset(file, "v", 1, 0);
    add_dataset(file, "m", 2, 0);
    add_dataset(file, "c", 1, 5);
    H5Fclose(file);
    return taken(path, size);
}

static enum rk_status dataset_attempt(const void *bytes, size_t size, struct rk_error *err) {
    static const char *const names[] = {"v", "m", "c", "/"};
    const char *path = fuzz_file(bytes, size);
    enum rk_status status = RK_EFORMAT;
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        struct rk_samples samples;
        enum rk_status one = rk_dataset_read(path, names[n], &samples, err);
        status = one == RK_OK ? RK_OK : status;
        rk_samples_clear(&samples);
    }
    return status;
}

const struct fuzz_target fuzz_dataset = {"dataset", "datasets of HDF5 files", dataset_seed,
                                         dataset_attempt, 2000};

/* ---- Spools ------------------------------------------------------------------------------------
 */

static const struct rk_spool_shape shape = {
    .origin = {.identity = "0123456789abcdef0123456789abcde", .run = "base-0001"},
    .columns = 3,
    .floats = 5};

static void *spool_seed(size_t k, size_t *size) {
    const double row[3] = {1, 2, 3};
    const float frame[5] = {1, 2, 3, 4, 5};
    const struct rk_spool_contact contacts[2] = {{0, 1, 2, 3, 4}, {5, -6, 7, 8, 9}};
    const char *path = temporary(".spool");
    struct rk_spool *spool;
    uint64_t length;
    if (k > 0) {
        return NULL;
    }
    fuzz_check(rk_spool_create(path, &shape, &spool, NULL) == RK_OK, "no spool");
    for (uint64_t step = 0; step < 6; step++) {
        fuzz_check(rk_spool_row(spool, step, row, NULL) == RK_OK, "no row");
        fuzz_check(step % 3 || rk_spool_contacts(spool, step, contacts, 2, NULL) == RK_OK,
                   "no contacts");
        fuzz_check(step % 3 || rk_spool_frame(spool, step, frame, NULL) == RK_OK, "no frame");
    }
    fuzz_check(rk_spool_sync(spool, &length, NULL) == RK_OK, "not written");
    rk_spool_close(spool);
    return taken(path, size);
}

static enum rk_status spool_attempt(const void *bytes, size_t size, struct rk_error *err) {
    struct rk_spool *spool = NULL;
    struct rk_spool_record record = {.kind = RK_SPOOL_ROW};
    const char *path = fuzz_file(bytes, size);
    enum rk_status status = rk_spool_resume(path, &shape, size, &spool, err);
    if (status == RK_OK) {
        status = rk_spool_rewind(spool, err);
        while (status == RK_OK && record.kind != RK_SPOOL_END) {
            status = rk_spool_next(spool, &record, err);
        }
        rk_spool_close(spool);
    }
    return status;
}

const struct fuzz_target fuzz_spool = {"spool", "spools of running replicas", spool_seed,
                                       spool_attempt, 4000};

/* ---- Checkpoints and seals: once as they are, once with a checksum that fits -------------------
 */

static void *checkpoint_seed(size_t k, size_t *size) {
    char state[40] = "the packed scene";
    const struct rk_checkpoint checkpoint = {
        .step = 100, .spool = 1000, .state = state, .size = sizeof state};
    const char *path = temporary(".ckpt");
    if (k > 0) {
        return NULL;
    }
    fuzz_check(rk_checkpoint_write(path, &origin, &checkpoint, NULL) == RK_OK, "no checkpoint");
    return taken(path, size);
}

static enum rk_status read_checkpoint(const void *bytes, size_t size, struct rk_error *err) {
    struct rk_checkpoint checkpoint;
    enum rk_status status =
        rk_checkpoint_read(fuzz_file(bytes, size), 0, &origin, &checkpoint, err);
    volatile unsigned char sum = 0;
    for (size_t i = 0; i < checkpoint.size && checkpoint.state; i++) {
        sum = (unsigned char)(sum + ((unsigned char *)checkpoint.state)[i]);
    }
    free(checkpoint.state);
    return status;
}

/* The bytes with an XXH64 of the first `covered` behind them. */
static enum rk_status with_sum(const void *bytes, size_t size, size_t covered,
                               enum rk_status (*read)(const void *, size_t, struct rk_error *),
                               struct rk_error *err) {
    char *block = malloc(size + 1);
    fuzz_check(block != NULL, "memory");
    memcpy(block, bytes, size);
    uint64_t sum = XXH64(block, covered, 0);
    memcpy(block + covered, &sum, sizeof sum);
    enum rk_status status = read(block, size, err);
    free(block);
    return status;
}

static enum rk_status checkpoint_attempt(const void *bytes, size_t size, struct rk_error *err) {
    enum rk_status status = read_checkpoint(bytes, size, err);
    if (size >= sizeof(uint64_t)) {
        status = with_sum(bytes, size, size - sizeof(uint64_t), read_checkpoint, err);
    }
    return status;
}

const struct fuzz_target fuzz_checkpoint = {"checkpoint", "checkpoints", checkpoint_seed,
                                            checkpoint_attempt, 3000};

static void *seal_seed(size_t k, size_t *size) {
    const struct rk_seal seal = {.origin = origin, .state = RK_SEAL_FAILED, .reason = "too fast"};
    const char *path = temporary(".sealed");
    if (k > 0) {
        return NULL;
    }
    FILE *file = fopen(path, "wb");
    fuzz_check(file && ftruncate(fileno(file), RK_SEAL_SIZE + 300) == 0 && fclose(file) == 0 &&
                   rk_seal_write(path, &seal, NULL) == RK_OK,
               "no sealed file");
    return taken(path, size);
}

static enum rk_status read_seal(const void *bytes, size_t size, struct rk_error *err) {
    struct rk_seal seal;
    enum rk_status status = rk_seal_verify(fuzz_file(bytes, size), &seal, err);
    if (status == RK_OK) {
        fuzz_check(memchr(seal.reason, 0, sizeof seal.reason) != NULL, "a reason without end");
        fuzz_check(memchr(seal.origin.run, 0, sizeof seal.origin.run) &&
                       memchr(seal.origin.identity, 0, sizeof seal.origin.identity),
                   "a name without end");
        fuzz_check(seal.state == RK_SEAL_DONE || seal.state == RK_SEAL_FAILED,
                   "a state of no kind");
    }
    return status;
}

static enum rk_status seal_attempt(const void *bytes, size_t size, struct rk_error *err) {
    enum rk_status status = read_seal(bytes, size, err);
    if (size >= RK_SEAL_SIZE) {
        status = with_sum(bytes, size, RK_SEAL_SIZE - sizeof(uint64_t), read_seal, err);
    }
    return status;
}

const struct fuzz_target fuzz_seal = {"seal", "seals of finished files", seal_seed, seal_attempt,
                                      3000};
