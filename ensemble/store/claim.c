#include "ensemble/store/claim.h"
#include "ensemble/store/files.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct rk_thing rk_thing_run(const struct rk_run *run) {
    struct rk_thing thing;
    snprintf(thing.name, sizeof thing.name, "runs/%s", run->id);
    return thing;
}

struct rk_thing rk_thing_bed(const char *bed) {
    struct rk_thing thing;
    snprintf(thing.name, sizeof thing.name, "beds/%.*s", RK_RUN_ID - 1, bed);
    return thing;
}

/* A chain grows by a link when the holder dies; so many deaths over one thing are none. */
enum { CHAIN_MAX = 4096 };

struct end {
    char holder[RK_WORKER_NAME]; /* "" when there is no link */
    struct rk_path link;         /* of the holder */
    struct rk_path next;         /* the name that a successor's link would have */
    int length;
};

static enum rk_status link_after(struct rk_path *path, const struct rk_worker *me,
                                 const struct rk_thing *thing, const char *before,
                                 struct rk_error *err) {
    const char *folder = rk_worker_folder(me);
    return before[0] == '\0'
               ? rk_path_set(path, err, "%s/%s.claim", folder, thing->name)
               : rk_path_set(path, err, "%s/%s.claim.%s", folder, thing->name, before);
}

static enum rk_status walk(const struct rk_worker *me, const struct rk_thing *thing,
                           struct end *end, struct rk_error *err) {
    memset(end, 0, sizeof *end);
    enum rk_status status = link_after(&end->next, me, thing, "", err);
    while (status == RK_OK) {
        char holder[RK_WORKER_NAME];
        ssize_t length = readlink(end->next.text, holder, sizeof holder - 1);
        if (length < 0) {
            return errno == ENOENT ? RK_OK : rk_fail_system(err, "read the claim", end->next.text);
        }
        holder[length] = '\0';
        if (length == 0 || strchr(holder, '/') || ++end->length > CHAIN_MAX) {
            return rk_fail(err, RK_EIO, "'%s' is no claim of reckon's; remove it", end->next.text);
        }
        end->link = end->next;
        memcpy(end->holder, holder, sizeof holder);
        status = link_after(&end->next, me, thing, holder, err);
    }
    return status;
}

/* Remove the links from the first to one's own. The first one first: a chain that lost its end
 * instead could be lengthened by somebody who then believed to hold it. What is left of a chain
 * without its beginning is out of use. */
static void remove_chain(const struct rk_worker *me, const struct rk_thing *thing) {
    char holder[RK_WORKER_NAME] = "";
    bool more = true;
    while (more && strcmp(holder, rk_worker_name(me)) != 0) {
        struct rk_path link;
        ssize_t length = -1;
        if (link_after(&link, me, thing, holder, NULL) == RK_OK) {
            length = readlink(link.text, holder, sizeof holder - 1);
        }
        more = length > 0 && unlink(link.text) == 0;
        holder[more ? length : 0] = '\0';
    }
}

enum rk_status rk_claim_take(const struct rk_worker *me, const struct rk_thing *thing, bool *mine,
                             char holder[RK_WORKER_NAME], struct rk_error *err) {
    const char *name = rk_worker_name(me);
    struct end end;
    *mine = false;
    enum rk_status status = walk(me, thing, &end, err);
    while (status == RK_OK) {
        if (end.holder[0] != '\0' && rk_worker_lives(me, end.holder)) {
            break;
        }
        struct rk_path link = end.next;
        bool made = symlink(name, link.text) == 0;
        if (!made && errno != EEXIST) {
            return rk_fail_system(err, "claim: make the link", link.text);
        }
        status = walk(me, thing, &end, err);
        /* The last link may be under this name and yet another: by another thread of this program.
         */
        *mine = status == RK_OK && made && strcmp(end.link.text, link.text) == 0;
        if (*mine) {
            break;
        }
        if (made && !rk_worker_known(me)) {
            break; /* others may have gone on from this link */
        }
        if (made) {
            unlink(link.text);
        }
    }
    if (holder && status == RK_OK) {
        memcpy(holder, end.holder, sizeof end.holder);
    }
    return status;
}

bool rk_claim_holds(const struct rk_worker *me, const struct rk_thing *thing) {
    struct end end;
    return rk_worker_known(me) && walk(me, thing, &end, NULL) == RK_OK &&
           strcmp(end.holder, rk_worker_name(me)) == 0;
}

void rk_claim_release(const struct rk_worker *me, const struct rk_thing *thing, bool finished) {
    struct end end;
    if (walk(me, thing, &end, NULL) == RK_OK && strcmp(end.holder, rk_worker_name(me)) == 0) {
        if (finished) {
            remove_chain(me, thing);
        } else {
            unlink(end.link.text);
        }
    }
}

static void sweep(const char *folder) {
    struct rk_path path;
    DIR *listing = opendir(folder);
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;) {
        const char *end = strstr(entry->d_name, ".claim.");
        if (end &&
            rk_path_set(&path, NULL, "%s/%.*s.claim", folder, (int)(end - entry->d_name),
                        entry->d_name) == RK_OK &&
            !rk_name_exists(path.text) &&
            rk_path_set(&path, NULL, "%s/%s", folder, entry->d_name) == RK_OK) {
            unlink(path.text);
        }
    }
    if (listing) {
        closedir(listing);
    }
}

void rk_claim_sweep(const struct rk_worker *me) {
    static const char *const folders[] = {"runs", "beds"};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        struct rk_path path;
        if (rk_path_set(&path, NULL, "%s/%s", rk_worker_folder(me), folders[i]) == RK_OK) {
            sweep(path.text);
        }
    }
}
