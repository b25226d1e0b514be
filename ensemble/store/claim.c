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

static bool is_mine(const struct rk_worker *me, const struct end *end) {
    return strcmp(end->holder, rk_worker_name(me)) == 0;
}

/* ---- Taking ---- */

/* The claim of a thing that no other thread of this program has. Where our name stands last it is
 * ours, also when it could not be given back before. *made: there is a link of ours now. */
static enum rk_status take(const struct rk_worker *me, const struct rk_thing *thing,
                           struct end *end, bool *made, struct rk_error *err) {
    enum rk_status status = walk(me, thing, end, err);
    *made = false;
    while (status == RK_OK && !is_mine(me, end) &&
           (end->holder[0] == '\0' || !rk_worker_lives(me, end->holder))) {
        struct rk_path link = end->next;
        *made = symlink(rk_worker_name(me), link.text) == 0;
        if (!*made && errno != EEXIST) {
            return rk_fail_system(err, "claim: make the link", link.text);
        }
        status = walk(me, thing, end, err);
        if (status == RK_OK && *made && !is_mine(me, end)) {
            if (!rk_worker_known(me, false)) {
                break; /* others may have gone on from this link */
            }
            unlink(link.text);
            *made = false;
        }
    }
    return status;
}

enum rk_status rk_claim_take(const struct rk_worker *me, const struct rk_thing *thing, bool *mine,
                             char holder[RK_WORKER_NAME], struct rk_error *err) {
    struct rk_held *held = rk_worker_held(me);
    struct end end;
    bool entered, made;
    *mine = false;
    enum rk_status status = rk_held_enter(held, thing, &entered, err);
    if (status == RK_OK && !entered) {
        snprintf(end.holder, sizeof end.holder, "%s", rk_worker_name(me));
    } else if (status == RK_OK) {
        status = take(me, thing, &end, &made, err);
        *mine = status == RK_OK && is_mine(me, &end);
        if (status != RK_OK && made) {
            rk_held_owe(held, thing, false);
        } else if (!*mine) {
            rk_held_leave(held, thing);
        }
    }
    if (holder && status == RK_OK) {
        memcpy(holder, end.holder, sizeof end.holder);
    }
    return status;
}

enum rk_status rk_claim_check(const struct rk_worker *me, const struct rk_thing *thing,
                              struct rk_error *err) {
    struct end end;
    enum rk_status status = walk(me, thing, &end, err);
    if (status == RK_OK && !(rk_worker_known(me, true) && is_mine(me, &end))) {
        status = rk_fail(err, RK_ECONFLICT, "another program has taken over %s", thing->name);
    }
    return status;
}

/* ---- Giving back ---- */

static enum rk_status remove_link(const char *link, struct rk_error *err) {
    return unlink(link) == 0 || errno == ENOENT ? RK_OK
                                                : rk_fail_system(err, "give back the claim", link);
}

/* Remove the links from the first to one's own. The first one first: a chain that lost its end
 * instead could be lengthened by somebody who then believed to hold it. What is left of a chain
 * without its beginning is out of use (rk_claim_sweep): only that the first goes must not fail. */
static enum rk_status remove_chain(const struct rk_worker *me, const struct rk_thing *thing,
                                   struct rk_error *err) {
    char holder[RK_WORKER_NAME] = "";
    enum rk_status status = RK_OK;
    bool more = true;
    for (int k = 0; more && strcmp(holder, rk_worker_name(me)) != 0; k++) {
        struct rk_path link;
        ssize_t length = -1;
        enum rk_status removed = link_after(&link, me, thing, holder, NULL);
        if (removed == RK_OK) {
            length = readlink(link.text, holder, sizeof holder - 1);
            removed = remove_link(link.text, k == 0 ? err : NULL);
        }
        status = k == 0 ? removed : status;
        more = length > 0 && removed == RK_OK;
        holder[more ? length : 0] = '\0';
    }
    return status;
}

enum rk_status rk_claim_release(const struct rk_worker *me, const struct rk_thing *thing,
                                bool finished, struct rk_error *err) {
    struct end end;
    enum rk_status status = walk(me, thing, &end, err);
    if (status == RK_OK && is_mine(me, &end)) {
        status = finished ? remove_chain(me, thing, err) : remove_link(end.link.text, err);
    }
    if (status == RK_OK) {
        rk_held_leave(rk_worker_held(me), thing);
    } else {
        rk_held_owe(rk_worker_held(me), thing, finished);
    }
    return status;
}

void rk_claim_release_owed(const struct rk_worker *me) {
    struct rk_held *held = rk_worker_held(me);
    struct rk_thing thing;
    bool finished;
    for (size_t n = rk_held_count_owed(held); n > 0 && rk_held_owed(held, &thing, &finished); n--) {
        rk_claim_release(me, &thing, finished, NULL);
    }
}

/* ---- What the dead left ---- */

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
