/* HDF5 with the error handling written once.
 *
 * A struct rk_h5 is one file being written or read. It remembers the first thing that went wrong;
 * after that every call on it does nothing (and gives an invalid id), so that a long chain of
 * writes needs one check, at rk_h5_close. What was left open is closed with the file.
 *
 * What is written depends on nothing but the calls: no times, fixed format version, fixed layout.
 * The same calls give the same bytes.
 *
 * Threads: the HDF5 library may be entered by one thread at a time. Between rk_h5_enter and
 * rk_h5_leave a thread has it for itself, and HDF5's own printing of errors is off; every function
 * below must be called in between.
 */
#ifndef RK_ENSEMBLE_STORE_HDF5_FILE_H
#define RK_ENSEMBLE_STORE_HDF5_FILE_H

#include "base/error.h"

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rk_h5_guard {
    H5E_auto2_t print;
    void *data;
};
struct rk_h5_guard rk_h5_enter(void);
void rk_h5_leave(struct rk_h5_guard guard);

/* The types of the store, little-endian in files, the machine's own in memory. */
enum rk_h5_type { RK_H5_REAL, RK_H5_FLOAT, RK_H5_COUNT, RK_H5_INT, RK_H5_BYTE };

struct rk_h5 {
    hid_t file;
    hid_t driver;     /* of a file being written, held until that is closed */
    const char *path; /* for messages; must outlive the struct */
    enum rk_status status;
    struct rk_error *err;
    int failure; /* errno of the first failed write (hdf5_driver.h); do not move the struct */
};

/* Which readers a file must suit: those of HDF5 1.8, or, for virtual datasets, of 1.10. */
enum rk_h5_format { RK_H5_FOR_1_8, RK_H5_FOR_1_10 };

/* Create (or overwrite) a file with a block of `user_block` bytes in front; open one to read. */
void rk_h5_create(struct rk_h5 *h5, const char *path, size_t user_block, enum rk_h5_format format,
                  struct rk_error *err);
void rk_h5_open(struct rk_h5 *h5, const char *path, struct rk_error *err);

/* Flush and close. The first failure of everything done with the file; RK_EIO for writing,
 * RK_EFORMAT for reading. */
enum rk_status rk_h5_close(struct rk_h5 *h5);

/* Record a failure, if it is the first: "cannot <verb> '<name>' in '<path>'", with HDF5's reason;
 * RK_EFORMAT for the verbs "read" and "open", else RK_EIO. */
void rk_h5_fail(struct rk_h5 *h5, const char *verb, const char *name);

hid_t rk_h5_group(struct rk_h5 *h5, hid_t parent, const char *name);
void rk_h5_release(struct rk_h5 *h5, hid_t id); /* close a group or dataset */
/* One more name for an object. */
void rk_h5_link(struct rk_h5 *h5, hid_t from, const char *name, hid_t to, const char *new_name);
void rk_h5_external(struct rk_h5 *h5, hid_t parent, const char *name, const char *file);

/* Attributes: text, or `count` numbers (a scalar for 0). */
void rk_h5_note(struct rk_h5 *h5, hid_t object, const char *name, const char *text);
void rk_h5_note_text_list(struct rk_h5 *h5, hid_t object, const char *name, const char *const *text,
                          size_t count);
void rk_h5_note_value(struct rk_h5 *h5, hid_t object, const char *name, enum rk_h5_type type,
                      size_t count, const void *values);

/* Datasets with their values, and a "unit" attribute if `unit` is neither NULL nor "". rank 0 is a
 * scalar. */
void rk_h5_values(struct rk_h5 *h5, hid_t parent, const char *name, enum rk_h5_type type, int rank,
                  const hsize_t *dims, const void *values, const char *unit);
void rk_h5_text(struct rk_h5 *h5, hid_t parent, const char *name, const char *text);
void rk_h5_text_list(struct rk_h5 *h5, hid_t parent, const char *name, const char *const *text,
                     size_t count);
/* Add a "description" to an object. */
void rk_h5_describe(struct rk_h5 *h5, hid_t parent, const char *name, const char *text);

/* A chunked dataset that grows along its first dimension in principle, `dims` long in fact, to be
 * written in order with rk_h5_rows, whole chunks at a time. */
struct rk_h5_series {
    enum rk_h5_type type;
    int rank;
    hsize_t dims[3], chunk[3];
    bool compress; /* shuffle and gzip -1 */
    const char *unit;
};
hid_t rk_h5_series(struct rk_h5 *h5, hid_t parent, const char *name,
                   const struct rk_h5_series *series);
void rk_h5_rows(struct rk_h5 *h5, hid_t dataset, const struct rk_h5_series *series, hsize_t first,
                hsize_t count, const void *values);

/* A property list (of groups, datasets or files) that records no times. */
hid_t rk_h5_properties(hid_t class_id);

/* Read a one-dimensional dataset of numbers as doubles: *values is the caller's (free). */
void rk_h5_read_list(struct rk_h5 *h5, const char *name, double **values, size_t *count);
/* Read a text as rk_h5_text wrote it: *text is the caller's (free). */
void rk_h5_read_text(struct rk_h5 *h5, const char *name, char **text);
/* Read a scalar number. */
double rk_h5_read_scalar(struct rk_h5 *h5, const char *name);
bool rk_h5_has(struct rk_h5 *h5, const char *name);

#endif
