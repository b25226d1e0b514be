#include "ensemble/store/hdf5_driver.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct driver_info {
    int *failure;
};

struct driver_file {
    H5FD_t shared; /* HDF5's part; must come first */
    int file;
    haddr_t end;     /* of what HDF5 has allocated */
    haddr_t written; /* of what is in the file, or would be */
    int *failure;
};

static struct driver_file *mine(H5FD_t *file) {
    return (struct driver_file *)(void *)file;
}

static const struct driver_file *mine_const(const H5FD_t *file) {
    return (const struct driver_file *)(const void *)file;
}

static H5FD_t *open_file(const char *name, unsigned flags, hid_t access, haddr_t most) {
    (void)most;
    const struct driver_info *info = H5Pget_driver_info(access);
    int mode = O_CLOEXEC | (flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY) |
               (flags & H5F_ACC_TRUNC ? O_TRUNC : 0) | (flags & H5F_ACC_CREAT ? O_CREAT : 0) |
               (flags & H5F_ACC_EXCL ? O_EXCL : 0);
    struct driver_file *file = info ? calloc(1, sizeof *file) : NULL;
    if (!file) {
        return NULL;
    }
    struct stat facts;
    file->failure = info->failure;
    file->file = open(name, mode, 0666);
    if (file->file < 0 || fstat(file->file, &facts) != 0) {
        *file->failure = errno;
        if (file->file >= 0) {
            close(file->file);
        }
        free(file);
        return NULL;
    }
    file->written = (haddr_t)facts.st_size;
    return &file->shared;
}

static void note(struct driver_file *file) {
    if (*file->failure == 0) {
        *file->failure = errno;
    }
}

static herr_t close_file(H5FD_t *shared) {
    struct driver_file *file = mine(shared);
    if (close(file->file) != 0) {
        note(file);
    }
    free(file);
    return 0;
}

static herr_t query(const H5FD_t *file, unsigned long *flags) {
    (void)file;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t get_end(const H5FD_t *file, H5FD_mem_t kind) {
    (void)kind;
    return mine_const(file)->end;
}

static herr_t set_end(H5FD_t *file, H5FD_mem_t kind, haddr_t end) {
    (void)kind;
    mine(file)->end = end;
    return 0;
}

static haddr_t get_written(const H5FD_t *file, H5FD_mem_t kind) {
    (void)kind;
    return mine_const(file)->written;
}

/* What was never written reads as zeros. */
static herr_t read_bytes(H5FD_t *shared, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size,
                         void *bytes) {
    (void)kind;
    (void)transfer;
    struct driver_file *file = mine(shared);
    char *next = bytes;
    while (size > 0) {
        ssize_t count = pread(file->file, next, size, (off_t)at);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count < 0) {
            note(file);
        }
        if (count <= 0) {
            memset(next, 0, size);
            break;
        }
        next += count;
        at += (haddr_t)count;
        size -= (size_t)count;
    }
    return 0;
}

static herr_t write_bytes(H5FD_t *shared, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size,
                          const void *bytes) {
    (void)kind;
    (void)transfer;
    struct driver_file *file = mine(shared);
    const char *next = bytes;
    haddr_t end = at + size;
    while (size > 0 && *file->failure == 0) {
        ssize_t count = pwrite(file->file, next, size, (off_t)at);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count <= 0) {
            errno = count == 0 ? ENOSPC : errno;
            note(file);
            break;
        }
        next += count;
        at += (haddr_t)count;
        size -= (size_t)count;
    }
    file->written = end > file->written ? end : file->written;
    return 0;
}

static herr_t truncate_file(H5FD_t *shared, hid_t transfer, hbool_t closing) {
    (void)transfer;
    (void)closing;
    struct driver_file *file = mine(shared);
    if (*file->failure == 0 && file->end != file->written &&
        ftruncate(file->file, (off_t)file->end) != 0) {
        note(file);
    }
    file->written = file->end;
    return 0;
}

static const H5FD_class_t driver = {
#ifdef H5FD_CLASS_VERSION
    .version = H5FD_CLASS_VERSION,
    .value = H5_VFD_RESERVED + 1,
#endif
    .name = "reckon",
    .maxaddr = ((haddr_t)1 << 62) - 1,
    .fc_degree = H5F_CLOSE_WEAK,
    .fapl_size = sizeof(struct driver_info),
    .open = open_file,
    .close = close_file,
    .query = query,
    .get_eoa = get_end,
    .set_eoa = set_end,
    .get_eof = get_written,
    .read = read_bytes,
    .write = write_bytes,
    .truncate = truncate_file,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

hid_t rk_h5_driver_set(hid_t access, int *failure) {
    hid_t id = H5FDregister(&driver);
    struct driver_info info = {failure};
    if (id >= 0 && H5Pset_driver(access, id, &info) < 0) {
        H5FDunregister(id);
        id = H5I_INVALID_HID;
    }
    return id;
}
