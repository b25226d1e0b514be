/* Cores that a crew has no run for, lent to the scenes of the runs that are left. */
#include "ensemble/runner/clock.h"
#include "ensemble/runner/crew.h"

/* How many threads the scene of a berth is to have now, and the cores for them; a core that is lent
 * is no other's until it is given back. */
static size_t settle_threads(struct rk_berth *berth, const struct rk_scene *scene) {
    struct rk_crew *crew = berth->crew;
    size_t most = rk_scene_grains(scene) / RK_PACE_GRAINS;
    pthread_mutex_lock(&crew->mutex);
    size_t held = rk_pace_held(&berth->pace), used = crew->working + crew->lent;
    size_t within = held + ((size_t)crew->threads > used ? (size_t)crew->threads - used : 0);
    size_t threads = rk_pace_next(&berth->pace, rk_clock(), rk_scene_steps(scene),
                                  most < within ? most : within);
    crew->lent += rk_pace_held(&berth->pace) - held;
    pthread_mutex_unlock(&crew->mutex);
    return threads;
}

static void add_working(struct rk_crew *crew, int berths) {
    pthread_mutex_lock(&crew->mutex);
    crew->working += (size_t)berths;
    pthread_mutex_unlock(&crew->mutex);
}

void rk_crew_leave_core(struct rk_crew *crew) {
    add_working(crew, -1);
}

void rk_crew_return_core(struct rk_crew *crew) {
    add_working(crew, 1);
}

bool rk_crew_wants_back(struct rk_berth *berth) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    bool wanted =
        rk_pace_held(&berth->pace) > 1 && crew->working + crew->lent > (size_t)crew->threads;
    pthread_mutex_unlock(&crew->mutex);
    return wanted;
}

void rk_crew_give_back(struct rk_berth *berth) {
    struct rk_crew *crew = berth->crew;
    pthread_mutex_lock(&crew->mutex);
    crew->lent -= rk_pace_held(&berth->pace) - 1;
    berth->pace = rk_pace_of_one();
    pthread_mutex_unlock(&crew->mutex);
}

/* A scene of another try has none of them yet. A shortage of memory leaves a scene as it is. */
void rk_crew_pace(struct rk_berth *berth, struct rk_scene *scene) {
    if (berth->fixed || rk_scene_grains(scene) < 2 * RK_PACE_GRAINS) {
        return;
    }
    if ((rk_scene_spec(scene)->threads == 0 && berth->pace.threads > 1) ||
        rk_crew_wants_back(berth)) {
        rk_crew_give_back(berth);
    }
    rk_scene_set_threads(scene, settle_threads(berth, scene), NULL);
}
