#include "ensemble/store/spool.h"
#include "base/memory.h"
#include "ensemble/store/files.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

struct header {
    uint64_t magic;
    struct rk_spool_shape shape; /* zeroed before it is filled: padding is part of the sum */
    uint64_t sum;
};
static const uint64_t magic = 0x316c6f6f70736b52; /* "Rkspool1" */

/* A record: kind, step, payload, sum of all that; every one a whole number of 8 bytes. The payload
 * of contacts begins with their number. */
struct rk_spool {
    FILE *file;
    struct rk_path path;
    struct rk_spool_shape shape;
    uint64_t length;                       /* of the whole file, in bytes */
    uint64_t count[RK_SPOOL_CONTACTS + 1]; /* records by kind */
    uint64_t contacts;                     /* in all of them */
    uint64_t at;                           /* where the next record is read from */
    uint64_t *record;
    uint64_t room; /* words of the largest payload so far */
};
enum { KIND, STEP, PAYLOAD };

static struct header header_of(const struct rk_spool_shape *shape) {
    struct header header;
    memset(&header, 0, sizeof header);
    header.magic = magic;
    memcpy(&header.shape.origin, &shape->origin, sizeof shape->origin);
    header.shape.columns = shape->columns;
    header.shape.floats = shape->floats;
    header.sum = XXH64(&header, offsetof(struct header, sum), 0);
    return header;
}

/* Payload of a kind in words of 8 bytes, the last one padded. */
static uint64_t words_of(const struct rk_spool_shape *shape, uint64_t kind) {
    return kind == RK_SPOOL_ROW ? shape->columns : shape->floats / 2 + shape->floats % 2;
}

static uint64_t words_of_contacts(uint64_t count) {
    const uint64_t bytes = count * sizeof(struct rk_spool_contact);
    return 1 + bytes / sizeof(uint64_t) + (bytes % sizeof(uint64_t) > 0);
}

static enum rk_status fail_file(const struct rk_spool *spool, const char *verb,
                                struct rk_error *err) {
    return rk_fail_system(err, verb, spool->path.text);
}

static enum rk_status damaged(const struct rk_spool *spool, struct rk_error *err) {
    return rk_fail(err, RK_EFORMAT, "'%s' is damaged", spool->path.text);
}

static enum rk_status make_room(struct rk_spool *spool, uint64_t words, struct rk_error *err) {
    if (spool->record && words <= spool->room) {
        return RK_OK;
    }
    free(spool->record);
    spool->record = rk_array_create(words + PAYLOAD + 1, sizeof *spool->record);
    spool->room = words;
    return spool->record ? RK_OK
                         : rk_fail(err, RK_EMEMORY, "not enough memory for the records of a run");
}

static enum rk_status open_file(const char *path, const struct rk_spool_shape *shape,
                                const char *mode, struct rk_spool **out, struct rk_error *err) {
    struct rk_spool *spool = calloc(1, sizeof *spool);
    if (!spool) {
        return rk_fail(err, RK_EMEMORY, "not enough memory for the records of a run");
    }
    spool->shape = *shape;
    uint64_t row = words_of(shape, RK_SPOOL_ROW), frame = words_of(shape, RK_SPOOL_FRAME);
    enum rk_status status = make_room(spool, row > frame ? row : frame, err);
    if (status == RK_OK) {
        status = rk_path_set(&spool->path, err, "%s", path);
    }
    if (status == RK_OK && !(spool->file = fopen(path, mode))) {
        status = errno == ENOENT && mode[0] == 'r'
                     ? rk_fail(err, RK_EFORMAT, "'%s' is missing", path)
                     : rk_fail_system(err, "open", path);
    }
    if (status != RK_OK) {
        rk_spool_close(spool);
        return status;
    }
    *out = spool;
    return RK_OK;
}

void rk_spool_close(struct rk_spool *spool) {
    if (!spool) {
        return;
    }
    if (spool->file) {
        fclose(spool->file); /* what counts has been synced by then, or is to be thrown away */
    }
    free(spool->record);
    free(spool);
}

enum rk_status rk_spool_create(const char *path, const struct rk_spool_shape *shape,
                               struct rk_spool **out, struct rk_error *err) {
    struct rk_spool *spool = NULL;
    enum rk_status status = open_file(path, shape, "w+be", &spool, err);
    if (status != RK_OK) {
        return status;
    }
    struct header header = header_of(shape);
    spool->length = sizeof header;
    if (fwrite(&header, sizeof header, 1, spool->file) != 1) {
        status = fail_file(spool, "write", err);
    } else {
        status = rk_file_sync_folder_of(path, err);
    }
    if (status != RK_OK) {
        rk_spool_close(spool);
        return status;
    }
    *out = spool;
    return RK_OK;
}

/* Write the record, whose payload of that many words is in place. */
static enum rk_status append(struct rk_spool *spool, uint64_t kind, uint64_t step, uint64_t words,
                             struct rk_error *err) {
    uint64_t *record = spool->record;
    record[KIND] = kind;
    record[STEP] = step;
    record[PAYLOAD + words] = XXH64(record, (PAYLOAD + words) * sizeof *record, 0);
    size_t count = PAYLOAD + words + 1;
    if (fwrite(record, sizeof *record, count, spool->file) != count) {
        return fail_file(spool, "write", err);
    }
    spool->length += count * sizeof *record;
    spool->count[kind]++;
    return RK_OK;
}

static enum rk_status append_fixed(struct rk_spool *spool, enum rk_spool_kind kind, uint64_t step,
                                   const void *payload, size_t bytes, struct rk_error *err) {
    uint64_t words = words_of(&spool->shape, kind);
    if (words > 0) {
        spool->record[PAYLOAD + words - 1] = 0;
        memcpy(spool->record + PAYLOAD, payload, bytes);
    }
    return append(spool, kind, step, words, err);
}

enum rk_status rk_spool_row(struct rk_spool *spool, uint64_t step, const double *row,
                            struct rk_error *err) {
    return append_fixed(spool, RK_SPOOL_ROW, step, row, spool->shape.columns * sizeof *row, err);
}

enum rk_status rk_spool_frame(struct rk_spool *spool, uint64_t step, const float *frame,
                              struct rk_error *err) {
    return append_fixed(spool, RK_SPOOL_FRAME, step, frame, spool->shape.floats * sizeof *frame,
                        err);
}

enum rk_status rk_spool_contacts(struct rk_spool *spool, uint64_t step,
                                 const struct rk_spool_contact *contacts, size_t count,
                                 struct rk_error *err) {
    uint64_t words = words_of_contacts(count);
    enum rk_status status = make_room(spool, words, err);
    if (status != RK_OK) {
        return status;
    }
    spool->record[PAYLOAD + words - 1] = 0;
    spool->record[PAYLOAD] = count;
    if (count > 0) {
        memcpy(spool->record + PAYLOAD + 1, contacts, count * sizeof *contacts);
    }
    status = append(spool, RK_SPOOL_CONTACTS, step, words, err);
    spool->contacts += status == RK_OK ? count : 0;
    return status;
}

enum rk_status rk_spool_sync(struct rk_spool *spool, uint64_t *length, struct rk_error *err) {
    if (fflush(spool->file) != 0 || fdatasync(fileno(spool->file)) != 0) {
        return fail_file(spool, "write", err);
    }
    *length = spool->length;
    return RK_OK;
}

uint64_t rk_spool_rows(const struct rk_spool *spool) {
    return spool->count[RK_SPOOL_ROW];
}

uint64_t rk_spool_frames(const struct rk_spool *spool) {
    return spool->count[RK_SPOOL_FRAME];
}

uint64_t rk_spool_contact_count(const struct rk_spool *spool) {
    return spool->contacts;
}

/* A seek flushes what is buffered and lets a stream turn between reading and writing. */
static enum rk_status seek(struct rk_spool *spool, uint64_t at, struct rk_error *err) {
    if (fseeko(spool->file, (off_t)at, SEEK_SET) != 0) {
        return fail_file(spool, "read", err);
    }
    spool->at = at;
    return RK_OK;
}

enum rk_status rk_spool_rewind(struct rk_spool *spool, struct rk_error *err) {
    return seek(spool, sizeof(struct header), err);
}

static enum rk_status take(struct rk_spool *spool, uint64_t *words, size_t count,
                           struct rk_error *err) {
    if (spool->length - spool->at < count * sizeof *words) {
        return damaged(spool, err);
    }
    if (fread(words, sizeof *words, count, spool->file) != count) {
        return ferror(spool->file) ? fail_file(spool, "read", err) : damaged(spool, err);
    }
    spool->at += count * sizeof *words;
    return RK_OK;
}

/* What follows kind and step, the sum included. A number of contacts is believed when the file has
 * that many bytes left. */
static enum rk_status take_payload(struct rk_spool *spool, uint64_t *words, struct rk_error *err) {
    uint64_t kind = spool->record[KIND], step = spool->record[STEP], count;
    if (kind == RK_SPOOL_ROW || kind == RK_SPOOL_FRAME) {
        *words = words_of(&spool->shape, kind);
        return take(spool, spool->record + PAYLOAD, *words + 1, err);
    }
    if (kind != RK_SPOOL_CONTACTS) {
        return damaged(spool, err);
    }
    enum rk_status status = take(spool, &count, 1, err);
    if (status != RK_OK) {
        return status;
    }
    if (count > (spool->length - spool->at) / sizeof(struct rk_spool_contact)) {
        return damaged(spool, err);
    }
    *words = words_of_contacts(count);
    status = make_room(spool, *words, err);
    if (status != RK_OK) {
        return status;
    }
    spool->record[KIND] = kind;
    spool->record[STEP] = step;
    spool->record[PAYLOAD] = count;
    return take(spool, spool->record + PAYLOAD + 1, *words, err);
}

enum rk_status rk_spool_next(struct rk_spool *spool, struct rk_spool_record *out,
                             struct rk_error *err) {
    *out = (struct rk_spool_record){.kind = RK_SPOOL_END};
    if (spool->at == spool->length) {
        return seek(spool, spool->length, err);
    }
    uint64_t words = 0;
    enum rk_status status = take(spool, spool->record, PAYLOAD, err);
    if (status == RK_OK) {
        status = take_payload(spool, &words, err);
    }
    if (status != RK_OK) {
        return status;
    }
    const uint64_t *record = spool->record;
    if (record[PAYLOAD + words] != XXH64(record, (PAYLOAD + words) * sizeof *record, 0)) {
        return damaged(spool, err);
    }
    out->kind = (enum rk_spool_kind)record[KIND];
    out->step = record[STEP];
    out->row = (const double *)(record + PAYLOAD);
    out->frame = (const float *)(record + PAYLOAD);
    out->contacts = (const struct rk_spool_contact *)(record + PAYLOAD + 1);
    out->contact_count = out->kind == RK_SPOOL_CONTACTS ? (size_t)record[PAYLOAD] : 0;
    return RK_OK;
}

/* Read and count every record up to spool->length. */
static enum rk_status check_records(struct rk_spool *spool, struct rk_error *err) {
    struct rk_spool_record record;
    enum rk_status status = rk_spool_rewind(spool, err);
    uint64_t count[RK_SPOOL_CONTACTS + 1] = {0}, contacts = 0;
    while (status == RK_OK) {
        status = rk_spool_next(spool, &record, err);
        if (status == RK_OK && record.kind == RK_SPOOL_END) {
            break;
        }
        count[record.kind]++;
        contacts += record.contact_count;
    }
    memcpy(spool->count, count, sizeof count);
    spool->contacts = contacts;
    return status;
}

enum rk_status rk_spool_resume(const char *path, const struct rk_spool_shape *shape,
                               uint64_t length, struct rk_spool **out, struct rk_error *err) {
    struct rk_spool *spool = NULL;
    enum rk_status status = open_file(path, shape, "r+be", &spool, err);
    if (status != RK_OK) {
        return status;
    }
    struct header expected = header_of(shape), found;
    /* Both are zeroed before they are filled, and the sum is over every byte. */
    /* NOLINTBEGIN(bugprone-suspicious-memory-comparison) */
    if (length < sizeof found || fread(&found, sizeof found, 1, spool->file) != 1 ||
        memcmp(&found, &expected, sizeof found) != 0) {
        status = rk_fail(err, RK_EFORMAT, "'%s' is damaged, or of another run", path);
    }
    /* NOLINTEND(bugprone-suspicious-memory-comparison) */
    spool->length = length;
    if (status == RK_OK) {
        status = check_records(spool, err);
    }
    if (status == RK_OK && ftruncate(fileno(spool->file), (off_t)length) != 0) {
        status = fail_file(spool, "shorten", err);
    }
    if (status == RK_OK) {
        status = seek(spool, length, err);
    }
    if (status != RK_OK) {
        rk_spool_close(spool);
        return status;
    }
    *out = spool;
    return RK_OK;
}
