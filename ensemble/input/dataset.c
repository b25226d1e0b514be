#include "ensemble/input/dataset.h"

#include "ensemble/store/hdf5_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static enum rk_status shape(hid_t type, hid_t space, struct rk_samples *out, struct rk_error *err) {
    hsize_t dims[2];
    if (H5Tget_class(type) != H5T_INTEGER && H5Tget_class(type) != H5T_FLOAT) {
        return rk_fail(err, RK_EINVALID, "is no dataset of numbers");
    }
    int rank = H5Sget_simple_extent_ndims(space);
    if (rank != 1 && rank != 2) {
        return rk_fail(err, RK_EINVALID,
                       "has %d dimensions; 1 (time) or 2 (replica x time) are expected", rank);
    }
    H5Sget_simple_extent_dims(space, dims, NULL);
    hsize_t replicas = rank == 2 ? dims[0] : 1;
    hsize_t samples = dims[rank - 1];
    if (replicas == 0 || samples == 0) {
        return rk_fail(err, RK_EINVALID, "is empty");
    }
    if (replicas > RK_SAMPLES_MAX / samples) {
        return rk_fail(err, RK_EINVALID, "has %llu x %llu values; at most %zu are read",
                       (unsigned long long)replicas, (unsigned long long)samples, RK_SAMPLES_MAX);
    }
    out->replicas = (size_t)replicas;
    out->samples = (size_t)samples;
    return RK_OK;
}

static enum rk_status read_values(hid_t dataset, struct rk_samples *out, struct rk_error *err) {
    size_t count = out->replicas * out->samples;
    out->values = calloc(count, sizeof *out->values);
    out->lengths = calloc(out->replicas, sizeof *out->lengths);
    if (!out->values || !out->lengths) {
        return rk_fail(err, RK_EMEMORY, "out of memory for %zu values", count);
    }
    for (size_t r = 0; r < out->replicas; r++) {
        out->lengths[r] = out->samples;
    }
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out->values) < 0) {
        return rk_fail(err, RK_EFORMAT, "cannot be read: the file is damaged or cut short");
    }
    return RK_OK;
}

static enum rk_status read_dataset(hid_t file, const char *path, struct rk_samples *out,
                                   struct rk_error *err) {
    hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t group = dataset < 0 ? H5Gopen2(file, path, H5P_DEFAULT) : -1;
    if (group >= 0) {
        H5Gclose(group);
        return rk_fail(err, RK_EINVALID,
                       "is a group, no dataset; 'h5dump -n FILE' lists what is in it");
    }
    if (dataset < 0) {
        return rk_fail(err, RK_EINVALID, "there is no such dataset in the file");
    }
    hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    enum rk_status status = type < 0 || space < 0
                                ? rk_fail(err, RK_EFORMAT, "cannot be read: the file is damaged")
                                : shape(type, space, out, err);
    if (status == RK_OK) {
        status = read_values(dataset, out, err);
    }
    if (space >= 0) {
        H5Sclose(space);
    }
    if (type >= 0) {
        H5Tclose(type);
    }
    H5Dclose(dataset);
    return status;
}

enum rk_status rk_dataset_read(const char *file, const char *dataset, struct rk_samples *out,
                               struct rk_error *err) {
    struct stat about;
    enum rk_status status;
    *out = (struct rk_samples){0};
    if (stat(file, &about) != 0) {
        status = rk_fail(err, RK_EIO, "%s", strerror(errno));
    } else {
        struct rk_h5_guard guard = rk_h5_enter();
        hid_t id = H5Fopen(file, H5F_ACC_RDONLY, H5P_DEFAULT);
        status = id < 0 ? rk_fail(err, RK_EFORMAT, "is no HDF5 file, or a damaged one")
                        : read_dataset(id, dataset, out, err);
        if (id >= 0) {
            H5Fclose(id);
        }
        rk_h5_leave(guard);
    }
    if (status != RK_OK) {
        rk_samples_clear(out);
        rk_error_locate(err, "%s:%s", file, dataset);
    }
    return status;
}
