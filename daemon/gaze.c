/* The newest direction of the gaze. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gaze.h"

/* Samples kept for clients: two seconds at 120 Hz, a quarter at a kilohertz. */
enum { KEPT = 256 };

/* How long one wait for a sample lasts, so that stopping never hangs on a silent device. */
static const uint64_t PATIENCE_NS = 100000000;

struct dmn_gaze {
    struct trk_source *source; /* read by one thread; trk_push() and trk_interrupt() by any */
    pthread_t thread;
    bool started;
    atomic_bool stop;
    void (*wake)(void *context);
    void *context;

    pthread_mutex_t lock; /* of all that follows */
    struct rnd_aim aim, frozen_aim;
    bool frozen, ended, has_view;
    float view[4], view_fov[2];
    uint64_t count, valid;
    struct dmn_gaze_sample kept[KEPT]; /* sample number n is at n % KEPT */
};

/* The recording that comes with fovead: beside an installed program, else in the source tree. */
static const char *shipped_log(char *buffer, size_t size)
{
    ssize_t length = readlink("/proc/self/exe", buffer, size - 1);
    char *slash;

    if (length > 0) {
        buffer[length] = '\0';
        for (int up = 0; up < 2; up++)
            if ((slash = strrchr(buffer, '/'))) *slash = '\0';
        length = (ssize_t)strlen(buffer);
        snprintf(buffer + length, size - (size_t)length, "/%s/fovead/hall.gaze", FOVEAD_DATADIR);
        if (!access(buffer, R_OK)) return buffer;
    }
    return FOVEAD_FIXTURES "/hall.gaze";
}

struct dmn_gaze *dmn_gaze_open(const struct dmn_options *options, char out_error[TRK_ERROR_SIZE])
{
    struct dmn_gaze *gaze = calloc(1, sizeof(*gaze));
    char buffer[4096];
    struct trk_source_options source = {.spec = options->gaze,
                                        .fallback_log = shipped_log(buffer, sizeof(buffer)),
                                        .speed = options->speed,
                                        .loop = options->loop,
                                        .virtual_clock = options->virtual_clock};

    if (!gaze) {
        snprintf(out_error, TRK_ERROR_SIZE, "out of memory");
        return NULL;
    }
    if (options->gaze && !(gaze->source = trk_open(&source, out_error))) {
        free(gaze);
        return NULL;
    }
    gaze->ended = !gaze->source;
    pthread_mutex_init(&gaze->lock, NULL);
    gaze->aim = (struct rnd_aim){.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}};
    memcpy(gaze->aim.fov, options->fov, sizeof(gaze->aim.fov));
    return gaze;
}

void dmn_gaze_close(struct dmn_gaze *gaze)
{
    if (!gaze) return;
    trk_close(gaze->source);
    pthread_mutex_destroy(&gaze->lock);
    free(gaze);
}

/* The direction is held where the sample has none; the head moves on all the same. */
static void accept(struct dmn_gaze *gaze, const struct trk_sample *sample)
{
    struct dmn_gaze_sample *kept;
    bool valid;

    pthread_mutex_lock(&gaze->lock);
    valid = trk_world_direction(sample, gaze->aim.gaze);
    if (valid) {
        gaze->aim.sequence = sample->sequence;
        gaze->aim.time_ns = sample->arrival_ns;
        gaze->valid++;
    }
    if (sample->valid & TRK_HEAD)
        memcpy(gaze->aim.view, sample->head + 3, sizeof(gaze->aim.view));
    else if (valid)
        dmn_orientation(gaze->aim.gaze, gaze->aim.view);
    kept = &gaze->kept[++gaze->count % KEPT];
    *kept = (struct dmn_gaze_sample){
        .sequence = sample->sequence,
        .device_ns = sample->device_ns,
        .arrival_ns = sample->arrival_ns,
        .valid = valid,
        .has_head = sample->valid & TRK_HEAD,
        .frozen = gaze->frozen,
    };
    memcpy(kept->direction, gaze->aim.gaze, sizeof(kept->direction));
    memcpy(kept->head, sample->head + 3, sizeof(kept->head));
    pthread_mutex_unlock(&gaze->lock);
}

/* True while there may be more. */
static bool read_one(struct dmn_gaze *gaze, uint64_t until_ns, enum trk_result *out_result)
{
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;

    *out_result = trk_read(gaze->source, until_ns, &sample, error);
    if (*out_result == TRK_SAMPLE) accept(gaze, &sample);
    if (*out_result == TRK_FAILED) fprintf(stderr, "fovead: gaze: %s; it stays where it was\n", error);
    if (*out_result == TRK_SAMPLE || *out_result == TRK_TIMEOUT) return true;
    pthread_mutex_lock(&gaze->lock);
    gaze->ended = true;
    pthread_mutex_unlock(&gaze->lock);
    return false;
}

static void *read_all(void *argument)
{
    struct dmn_gaze *gaze = argument;
    enum trk_result result;

    while (!atomic_load(&gaze->stop) && read_one(gaze, dmn_now_ns() + PATIENCE_NS, &result))
        if (result == TRK_SAMPLE) gaze->wake(gaze->context);
    gaze->wake(gaze->context);
    return NULL;
}

bool dmn_gaze_start(struct dmn_gaze *gaze, void (*wake)(void *context), void *context)
{
    if (!gaze->source) return true;
    gaze->wake = wake;
    gaze->context = context;
    gaze->started = !pthread_create(&gaze->thread, NULL, read_all, gaze);
    return gaze->started;
}

void dmn_gaze_stop(struct dmn_gaze *gaze)
{
    if (!gaze->started) return;
    atomic_store(&gaze->stop, true);
    trk_interrupt(gaze->source);
    pthread_join(gaze->thread, NULL);
    gaze->started = false;
}

void dmn_gaze_advance(struct dmn_gaze *gaze, uint64_t now_ns)
{
    enum trk_result result = TRK_SAMPLE;

    while (!gaze->ended && result == TRK_SAMPLE && read_one(gaze, now_ns, &result)) continue;
}

void dmn_gaze_aim(struct dmn_gaze *gaze, struct rnd_aim *out_aim)
{
    pthread_mutex_lock(&gaze->lock);
    *out_aim = gaze->frozen ? gaze->frozen_aim : gaze->aim;
    if (gaze->has_view) {
        memcpy(out_aim->view, gaze->view, sizeof(out_aim->view));
        memcpy(out_aim->fov, gaze->view_fov, sizeof(out_aim->fov));
    }
    pthread_mutex_unlock(&gaze->lock);
}

void dmn_gaze_state(struct dmn_gaze *gaze, struct dmn_gaze_state *out_state)
{
    pthread_mutex_lock(&gaze->lock);
    *out_state = (struct dmn_gaze_state){
        .samples = gaze->count,
        .valid = gaze->valid,
        .frozen = gaze->frozen,
        .ended = gaze->ended,
        .source = gaze->source ? trk_describe(gaze->source) : "none",
    };
    memcpy(out_state->direction, gaze->aim.gaze, sizeof(out_state->direction));
    pthread_mutex_unlock(&gaze->lock);
}

bool dmn_gaze_next(struct dmn_gaze *gaze, uint64_t *cursor, struct dmn_gaze_sample *out_sample)
{
    bool found;

    pthread_mutex_lock(&gaze->lock);
    found = *cursor < gaze->count;
    if (found) {
        uint64_t oldest = gaze->count < KEPT ? 1 : gaze->count - KEPT + 1;

        *cursor = *cursor ? *cursor + 1 : gaze->count;
        if (*cursor < oldest) *cursor = oldest;
        *out_sample = gaze->kept[*cursor % KEPT];
    }
    pthread_mutex_unlock(&gaze->lock);
    return found;
}

bool dmn_gaze_has_next(struct dmn_gaze *gaze, uint64_t cursor)
{
    bool found;

    pthread_mutex_lock(&gaze->lock);
    found = cursor < gaze->count;
    pthread_mutex_unlock(&gaze->lock);
    return found;
}

void dmn_gaze_freeze(struct dmn_gaze *gaze, bool frozen)
{
    pthread_mutex_lock(&gaze->lock);
    if (frozen && !gaze->frozen) gaze->frozen_aim = gaze->aim;
    gaze->frozen = frozen;
    pthread_mutex_unlock(&gaze->lock);
}

void dmn_gaze_push(struct dmn_gaze *gaze, const float direction[3])
{
    if (gaze->source) trk_push(gaze->source, direction, dmn_now_ns());
}

void dmn_gaze_view(struct dmn_gaze *gaze, const float orientation[4], float fov_x, float fov_y)
{
    pthread_mutex_lock(&gaze->lock);
    gaze->has_view = orientation;
    if (orientation) {
        memcpy(gaze->view, orientation, sizeof(gaze->view));
        gaze->view_fov[0] = fov_x;
        gaze->view_fov[1] = fov_y;
    }
    pthread_mutex_unlock(&gaze->lock);
}
