#include "ensemble/store/hdf5_file.h"
#include "base/memory.h"
#include "ensemble/store/files.h"
#include "ensemble/store/hdf5_driver.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* The one piece of global state: it guards a library that is itself one global state. */
static pthread_mutex_t library = PTHREAD_MUTEX_INITIALIZER;

struct rk_h5_guard rk_h5_enter(void) {
    pthread_mutex_lock(&library);
    struct rk_h5_guard guard = {NULL, NULL};
    H5Eget_auto2(H5E_DEFAULT, &guard.print, &guard.data);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    return guard;
}

void rk_h5_leave(struct rk_h5_guard guard) {
    H5Eset_auto2(H5E_DEFAULT, guard.print, guard.data);
    pthread_mutex_unlock(&library);
}

static hid_t file_type_of(enum rk_h5_type type) {
    switch (type) {
    case RK_H5_REAL:
        return H5T_IEEE_F64LE;
    case RK_H5_FLOAT:
        return H5T_IEEE_F32LE;
    case RK_H5_COUNT:
        return H5T_STD_U64LE;
    case RK_H5_INT:
        return H5T_STD_I32LE;
    case RK_H5_BYTE:
        return H5T_STD_U8LE;
    }
    return H5I_INVALID_HID;
}

static hid_t memory_type_of(enum rk_h5_type type) {
    switch (type) {
    case RK_H5_REAL:
        return H5T_NATIVE_DOUBLE;
    case RK_H5_FLOAT:
        return H5T_NATIVE_FLOAT;
    case RK_H5_COUNT:
        return H5T_NATIVE_UINT64;
    case RK_H5_INT:
        return H5T_NATIVE_INT32;
    case RK_H5_BYTE:
        return H5T_NATIVE_UINT8;
    }
    return H5I_INVALID_HID;
}

/* HDF5 stacks its reasons from the public call inwards; the innermost says most. */
static herr_t innermost(unsigned depth, const H5E_error2_t *reason, void *text) {
    (void)depth;
    if (reason->desc) {
        char *out = text;
        out[0] = '\0';
        strncat(out, reason->desc, 199);
    }
    return 0;
}

/* Has a write failed behind HDF5's back? Then that is the failure, if it is the first. */
static void check_writes(struct rk_h5 *h5) {
    if (h5->status == RK_OK && h5->failure != 0) {
        errno = h5->failure;
        h5->status = rk_fail_system(h5->err, "write", h5->path);
    }
}

void rk_h5_fail(struct rk_h5 *h5, const char *verb, const char *name) {
    check_writes(h5); /* the system's reason says more than what HDF5 makes of it */
    if (h5->status != RK_OK) {
        return;
    }
    char reason[200] = "no reason given";
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, innermost, reason);
    bool reading = strcmp(verb, "read") == 0 || strcmp(verb, "open") == 0;
    h5->status = rk_fail(h5->err, reading ? RK_EFORMAT : RK_EIO,
                         "cannot %s '%s' in '%s': HDF5 says \"%s\"", verb, name, h5->path, reason);
}

hid_t rk_h5_properties(hid_t class_id) {
    hid_t list = H5Pcreate(class_id);
    if (list >= 0 && class_id != H5P_FILE_ACCESS && H5Pset_obj_track_times(list, false) < 0) {
        H5Pclose(list);
        return H5I_INVALID_HID;
    }
    return list;
}

static void start(struct rk_h5 *h5, const char *path, struct rk_error *err) {
    *h5 = (struct rk_h5){.file = H5I_INVALID_HID,
                         .driver = H5I_INVALID_HID,
                         .path = path,
                         .status = RK_OK,
                         .err = err};
}

void rk_h5_create(struct rk_h5 *h5, const char *path, size_t user_block, enum rk_h5_format format,
                  struct rk_error *err) {
    start(h5, path, err);
    /* What maps the rows of a virtual dataset would stay in memory until the file is closed. */
    H5F_libver_t version = format == RK_H5_FOR_1_8 ? H5F_LIBVER_V18 : H5F_LIBVER_V110;
    hid_t creation = rk_h5_properties(H5P_FILE_CREATE);
    hid_t access = rk_h5_properties(H5P_FILE_ACCESS);
    if (creation < 0 || access < 0 || H5Pset_userblock(creation, user_block) < 0 ||
        H5Pset_libver_bounds(access, version, version) < 0 ||
        (h5->driver = rk_h5_driver_set(access, &h5->failure)) < 0 ||
        H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) < 0 ||
        H5Pset_evict_on_close(access, format == RK_H5_FOR_1_10) < 0 ||
        (h5->file = H5Fcreate(path, H5F_ACC_TRUNC, creation, access)) < 0) {
        rk_h5_fail(h5, "create", "/");
    }
    H5Pclose(creation);
    H5Pclose(access);
}

void rk_h5_open(struct rk_h5 *h5, const char *path, struct rk_error *err) {
    start(h5, path, err);
    hid_t access = rk_h5_properties(H5P_FILE_ACCESS);
    if (access < 0 || H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) < 0 ||
        (h5->file = H5Fopen(path, H5F_ACC_RDONLY, access)) < 0) {
        rk_h5_fail(h5, "open", "/");
    }
    H5Pclose(access);
}

enum rk_status rk_h5_close(struct rk_h5 *h5) {
    if (h5->file >= 0) {
        if (h5->status == RK_OK && H5Fflush(h5->file, H5F_SCOPE_GLOBAL) < 0) {
            rk_h5_fail(h5, "write", "/");
        }
        if (H5Fclose(h5->file) < 0) {
            rk_h5_fail(h5, "close", "/");
        }
        h5->file = H5I_INVALID_HID;
    }
    if (h5->driver >= 0) {
        H5FDunregister(h5->driver);
        h5->driver = H5I_INVALID_HID;
    }
    check_writes(h5);
    return h5->status;
}

hid_t rk_h5_group(struct rk_h5 *h5, hid_t parent, const char *name) {
    if (h5->status != RK_OK) {
        return H5I_INVALID_HID;
    }
    hid_t group = H5I_INVALID_HID;
    hid_t creation = rk_h5_properties(H5P_GROUP_CREATE);
    if (creation < 0 ||
        (group = H5Gcreate2(parent, name, H5P_DEFAULT, creation, H5P_DEFAULT)) < 0) {
        rk_h5_fail(h5, "write", name);
    }
    H5Pclose(creation);
    return group;
}

void rk_h5_release(struct rk_h5 *h5, hid_t id) {
    if (id >= 0 && H5Oclose(id) < 0) {
        rk_h5_fail(h5, "close", "an object");
    }
}

void rk_h5_link(struct rk_h5 *h5, hid_t from, const char *name, hid_t to, const char *new_name) {
    if (h5->status == RK_OK &&
        H5Lcreate_hard(from, name, to, new_name, H5P_DEFAULT, H5P_DEFAULT) < 0) {
        rk_h5_fail(h5, "write", new_name);
    }
}

void rk_h5_external(struct rk_h5 *h5, hid_t parent, const char *name, const char *file) {
    if (h5->status == RK_OK &&
        H5Lcreate_external(file, "/", parent, name, H5P_DEFAULT, H5P_DEFAULT) < 0) {
        rk_h5_fail(h5, "write", name);
    }
}

/* A string type just long enough: fixed-length strings are part of the object, so that the bytes
 * of the file do not depend on a heap. */
static hid_t text_type(size_t length) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && (H5Tset_size(type, length + 1) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)) {
        H5Tclose(type);
        return H5I_INVALID_HID;
    }
    return type;
}

static hid_t space_of(int rank, const hsize_t *dims) {
    return rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, dims, NULL);
}

static void write_attribute(struct rk_h5 *h5, hid_t object, const char *name, hid_t file_type,
                            hid_t memory_type, size_t count, const void *values) {
    if (h5->status != RK_OK) {
        return;
    }
    hid_t space = space_of(count > 0, &(hsize_t){count});
    hid_t attribute = H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0 || H5Awrite(attribute, memory_type, values) < 0) {
        rk_h5_fail(h5, "write", name);
    }
    H5Aclose(attribute);
    H5Sclose(space);
}

void rk_h5_note(struct rk_h5 *h5, hid_t object, const char *name, const char *text) {
    hid_t type = text_type(strlen(text));
    write_attribute(h5, object, name, type, type, 0, text);
    H5Tclose(type);
}

/* `count` texts in fields of one width, *width being the longest and its NUL; NULL, and an error,
 * without memory. */
static char *text_block(struct rk_h5 *h5, const char *const *text, size_t count, size_t *width) {
    *width = 1;
    for (size_t i = 0; i < count; i++) {
        *width = strlen(text[i]) + 1 > *width ? strlen(text[i]) + 1 : *width;
    }
    char *block = calloc(count + 1, *width);
    if (!block && h5->status == RK_OK) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to write '%s'", h5->path);
    }
    for (size_t i = 0; block && i < count; i++) {
        memcpy(block + i * *width, text[i], strlen(text[i]));
    }
    return block;
}

void rk_h5_note_text_list(struct rk_h5 *h5, hid_t object, const char *name, const char *const *text,
                          size_t count) {
    size_t width;
    char *block = text_block(h5, text, count, &width);
    hid_t type = text_type(width - 1);
    write_attribute(h5, object, name, type, type, count, block);
    H5Tclose(type);
    free(block);
}

void rk_h5_note_value(struct rk_h5 *h5, hid_t object, const char *name, enum rk_h5_type type,
                      size_t count, const void *values) {
    write_attribute(h5, object, name, file_type_of(type), memory_type_of(type), count, values);
}

static void write_dataset(struct rk_h5 *h5, hid_t parent, const char *name, hid_t file_type,
                          hid_t memory_type, int rank, const hsize_t *dims, const void *values,
                          const char *unit) {
    if (h5->status != RK_OK) {
        return;
    }
    hid_t creation = rk_h5_properties(H5P_DATASET_CREATE);
    hid_t space = space_of(rank, dims);
    hid_t dataset = H5Dcreate2(parent, name, file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    if (dataset < 0 || H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        rk_h5_fail(h5, "write", name);
    }
    if (unit && *unit != '\0') {
        rk_h5_note(h5, dataset, "unit", unit);
    }
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
}

void rk_h5_values(struct rk_h5 *h5, hid_t parent, const char *name, enum rk_h5_type type, int rank,
                  const hsize_t *dims, const void *values, const char *unit) {
    write_dataset(h5, parent, name, file_type_of(type), memory_type_of(type), rank, dims, values,
                  unit);
}

void rk_h5_text(struct rk_h5 *h5, hid_t parent, const char *name, const char *text) {
    hid_t type = text_type(strlen(text));
    write_dataset(h5, parent, name, type, type, 0, NULL, text, NULL);
    H5Tclose(type);
}

void rk_h5_text_list(struct rk_h5 *h5, hid_t parent, const char *name, const char *const *text,
                     size_t count) {
    size_t width;
    char *block = text_block(h5, text, count, &width);
    hid_t type = text_type(width - 1);
    hsize_t dims = count;
    write_dataset(h5, parent, name, type, type, 1, &dims, block, NULL);
    H5Tclose(type);
    free(block);
}

void rk_h5_describe(struct rk_h5 *h5, hid_t parent, const char *name, const char *text) {
    if (h5->status == RK_OK && text && *text != '\0') {
        hid_t object = H5Oopen(parent, name, H5P_DEFAULT);
        rk_h5_note(h5, object, "description", text);
        rk_h5_release(h5, object);
    }
}

hid_t rk_h5_series(struct rk_h5 *h5, hid_t parent, const char *name,
                   const struct rk_h5_series *series) {
    if (h5->status != RK_OK) {
        return H5I_INVALID_HID;
    }
    hsize_t most[3] = {H5S_UNLIMITED, series->dims[1], series->dims[2]};
    hid_t space = H5Screate_simple(series->rank, series->dims, most);
    hid_t creation = rk_h5_properties(H5P_DATASET_CREATE);
    hid_t dataset = H5I_INVALID_HID;
    if (space < 0 || creation < 0 || H5Pset_chunk(creation, series->rank, series->chunk) < 0 ||
        (series->compress && (H5Pset_shuffle(creation) < 0 || H5Pset_deflate(creation, 1) < 0)) ||
        (dataset = H5Dcreate2(parent, name, file_type_of(series->type), space, H5P_DEFAULT,
                              creation, H5P_DEFAULT)) < 0) {
        rk_h5_fail(h5, "write", name);
    }
    if (series->unit && *series->unit != '\0') {
        rk_h5_note(h5, dataset, "unit", series->unit);
    }
    H5Sclose(space);
    H5Pclose(creation);
    return dataset;
}

void rk_h5_rows(struct rk_h5 *h5, hid_t dataset, const struct rk_h5_series *series, hsize_t first,
                hsize_t count, const void *values) {
    if (h5->status != RK_OK || count == 0) {
        return;
    }
    hsize_t from[3] = {first, 0, 0};
    hsize_t size[3] = {count, series->dims[1], series->dims[2]};
    hid_t file_space = H5Dget_space(dataset);
    hid_t memory_space = H5Screate_simple(series->rank, size, NULL);
    if (file_space < 0 || memory_space < 0 ||
        H5Sselect_hyperslab(file_space, H5S_SELECT_SET, from, NULL, size, NULL) < 0 ||
        H5Dwrite(dataset, memory_type_of(series->type), memory_space, file_space, H5P_DEFAULT,
                 values) < 0) {
        rk_h5_fail(h5, "write", "the rows of a series");
    }
    H5Sclose(file_space);
    H5Sclose(memory_space);
    check_writes(h5);
}

bool rk_h5_has(struct rk_h5 *h5, const char *name) {
    return h5->status == RK_OK && H5Lexists(h5->file, name, H5P_DEFAULT) > 0;
}

void rk_h5_read_list(struct rk_h5 *h5, const char *name, double **values, size_t *count) {
    *values = NULL;
    *count = 0;
    if (h5->status != RK_OK) {
        return;
    }
    hid_t dataset = H5Dopen2(h5->file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(dataset);
    hsize_t length = 0;
    if (space < 0 || H5Sget_simple_extent_ndims(space) != 1 ||
        H5Sget_simple_extent_dims(space, &length, NULL) < 0) {
        rk_h5_fail(h5, "read", name);
    } else if (!(*values = rk_array_create(length, sizeof **values))) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to read '%s'", h5->path);
    } else if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0) {
        rk_h5_fail(h5, "read", name);
        free(*values);
        *values = NULL;
    } else {
        *count = length;
    }
    H5Sclose(space);
    H5Dclose(dataset);
}

void rk_h5_read_text(struct rk_h5 *h5, const char *name, char **text) {
    *text = NULL;
    if (h5->status != RK_OK) {
        return;
    }
    hid_t dataset = H5Dopen2(h5->file, name, H5P_DEFAULT);
    hid_t type = H5Dget_type(dataset);
    size_t size = type >= 0 && H5Tget_class(type) == H5T_STRING ? H5Tget_size(type) : 0;
    if (size == 0) {
        rk_h5_fail(h5, "read", name);
    } else if (!(*text = calloc(size + 1, 1))) {
        h5->status = rk_fail(h5->err, RK_EMEMORY, "not enough memory to read '%s'", h5->path);
    } else if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0) {
        rk_h5_fail(h5, "read", name);
    }
    H5Tclose(type);
    H5Dclose(dataset);
}

double rk_h5_read_scalar(struct rk_h5 *h5, const char *name) {
    double value = 0;
    if (h5->status != RK_OK) {
        return value;
    }
    hid_t dataset = H5Dopen2(h5->file, name, H5P_DEFAULT);
    hid_t space = H5Dget_space(dataset);
    if (space < 0 || H5Sget_simple_extent_npoints(space) != 1 ||
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) < 0) {
        rk_h5_fail(h5, "read", name);
    }
    H5Sclose(space);
    H5Dclose(dataset);
    return value;
}
