#include "ensemble/store/checkpoint.h"
#include "ensemble/store/files.h"
#include "rk_code.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <xxhash.h>

/* The block of a file: this header, the packed scene, the sum of both. */
struct header {
    uint64_t magic;
    struct rk_origin origin;
    char version[39]; /* of the code: another version may pack or step differently */
    uint64_t step, spool, size;
    struct rk_preparation preparation;
};
static const uint64_t magic = 0x3274706b63736b52; /* "Rksckpt2" */

enum rk_status rk_checkpoint_pack(struct rk_checkpoint *into, const struct rk_scene *scene,
                                  const struct rk_preparation *preparation, struct rk_error *err) {
    size_t size = rk_scene_packed_size(scene);
    void *state = size <= into->size ? into->state : realloc(into->state, size);
    if (!state) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for a checkpoint of %zu bytes", size);
    }
    rk_scene_pack(scene, state);
    *into = (struct rk_checkpoint){
        .step = rk_scene_steps(scene), .preparation = *preparation, .state = state, .size = size};
    return RK_OK;
}

enum rk_status rk_checkpoint_unpack(const struct rk_checkpoint *checkpoint, struct rk_scene *scene,
                                    struct rk_error *err) {
    enum rk_status status = rk_scene_unpack(scene, checkpoint->state, checkpoint->size, err);
    return status == RK_OK && rk_scene_steps(scene) != checkpoint->step
               ? rk_fail(err, RK_EFORMAT, "the checkpoint's state is not of its step")
               : status;
}

static struct header header_of(const struct rk_origin *origin, const struct rk_checkpoint *c) {
    struct header header;
    memset(&header, 0, sizeof header); /* padding included */
    header.magic = magic;
    header.origin = *origin;
    memcpy(header.version, RK_CODE, sizeof RK_CODE);
    _Static_assert(sizeof RK_CODE <= sizeof header.version, "the version has room");
    header.step = c->step;
    header.spool = c->spool;
    header.size = c->size;
    header.preparation = c->preparation;
    return header;
}

static enum rk_status path_of(struct rk_path *out, const char *path, int generation,
                              struct rk_error *err) {
    return rk_path_set(out, err, "%s%s", path, generation == 0 ? "" : ".old");
}

/* The last one steps back, unless there is none. */
static enum rk_status keep_last(const char *path, struct rk_error *err) {
    struct rk_path old;
    enum rk_status status = path_of(&old, path, 1, err);
    if (status == RK_OK && rename(path, old.text) != 0 && errno != ENOENT) {
        status = rk_fail_system(err, "rename", path);
    }
    return status;
}

enum rk_status rk_checkpoint_write(const char *path, const struct rk_origin *origin,
                                   const struct rk_checkpoint *checkpoint, struct rk_error *err) {
    struct rk_path temporary;
    enum rk_status status = rk_path_set(&temporary, err, "%s.new", path);
    if (status != RK_OK) {
        return status;
    }
    struct header header = header_of(origin, checkpoint);
    size_t size = sizeof header + checkpoint->size + sizeof(uint64_t);
    char *block = malloc(size);
    if (!block) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for a checkpoint of %zu bytes", size);
    }
    memcpy(block, &header, sizeof header);
    memcpy(block + sizeof header, checkpoint->state, checkpoint->size);
    uint64_t sum = XXH64(block, size - sizeof sum, 0);
    memcpy(block + size - sizeof sum, &sum, sizeof sum);
    status = rk_file_put(temporary.text, block, size, err);
    free(block);
    if (status == RK_OK) {
        status = keep_last(path, err);
    }
    return status == RK_OK ? rk_file_publish(temporary.text, path, err) : status;
}

static enum rk_status read_block(FILE *file, const char *path, char **block, size_t *size,
                                 struct rk_error *err) {
    struct stat facts;
    if (fstat(fileno(file), &facts) != 0) {
        return rk_fail_system(err, "read", path);
    }
    *size = (size_t)facts.st_size;
    *block = malloc(*size + 1);
    if (!*block) {
        return rk_fail(err, RK_EMEMORY, "not enough memory to read '%s'", path);
    }
    if (fread(*block, 1, *size, file) != *size) {
        return rk_fail_system(err, "read", path);
    }
    return RK_OK;
}

static enum rk_status parse(const char *block, size_t size, const char *path,
                            const struct rk_origin *origin, struct rk_checkpoint *out,
                            struct rk_error *err) {
    struct header header;
    uint64_t sum;
    if (size < sizeof header + sizeof sum) {
        return rk_fail(err, RK_EFORMAT, "'%s' is damaged: too short", path);
    }
    memcpy(&header, block, sizeof header);
    memcpy(&sum, block + size - sizeof sum, sizeof sum);
    if (header.magic != magic || sum != XXH64(block, size - sizeof sum, 0) ||
        header.size != size - sizeof header - sizeof sum) {
        return rk_fail(err, RK_EFORMAT, "'%s' is damaged", path);
    }
    if (memcmp(&header.origin, origin, sizeof *origin) != 0) {
        return rk_fail(err, RK_EFORMAT, "'%s' belongs to another run", path);
    }
    if (strncmp(header.version, RK_CODE, sizeof header.version) != 0) {
        return rk_fail(err, RK_EFORMAT, "'%s' was written by version %.38s, this is %s", path,
                       header.version, RK_CODE);
    }
    *out = (struct rk_checkpoint){.step = header.step,
                                  .spool = header.spool,
                                  .preparation = header.preparation,
                                  .size = header.size};
    return RK_OK;
}

enum rk_status rk_checkpoint_read(const char *path, int generation, const struct rk_origin *origin,
                                  struct rk_checkpoint *out, struct rk_error *err) {
    memset(out, 0, sizeof *out);
    struct rk_path name;
    enum rk_status status = path_of(&name, path, generation, err);
    if (status != RK_OK) {
        return status;
    }
    FILE *file = fopen(name.text, "rbe");
    if (!file) {
        return errno == ENOENT ? RK_OK : rk_fail_system(err, "open", name.text);
    }
    char *block = NULL;
    size_t size = 0;
    status = read_block(file, name.text, &block, &size, err);
    fclose(file);
    if (status == RK_OK) {
        status = parse(block, size, name.text, origin, out, err);
    }
    if (status != RK_OK) {
        free(block);
        return status;
    }
    memmove(block, block + sizeof(struct header), out->size);
    out->state = block;
    return RK_OK;
}

bool rk_checkpoint_exists(const char *path) {
    struct rk_path old;
    return rk_file_exists(path) ||
           (path_of(&old, path, 1, NULL) == RK_OK && rk_file_exists(old.text));
}

enum rk_status rk_checkpoint_remove(const char *path, struct rk_error *err) {
    static const char *const endings[] = {"", ".old", ".new"};
    enum rk_status status = RK_OK;
    for (size_t i = 0; status == RK_OK && i < sizeof endings / sizeof *endings; i++) {
        struct rk_path name;
        status = rk_path_set(&name, err, "%s%s", path, endings[i]);
        if (status == RK_OK) {
            status = rk_file_remove(name.text, err);
        }
    }
    return status;
}
