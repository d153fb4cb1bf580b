/* The gaze source that is in use, and the aim that follows from its samples. */
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cglm/cglm.h>

#include "gaze.h"
#include "recording.h"
#include "recentring.h"

/* Samples kept for clients: two seconds at 120 Hz, a quarter at a kilohertz. */
enum { KEPT = 256 };

/* How long one wait for a sample lasts: silence is noticed this soon, and stopping waits no longer. */
static const uint64_t PATIENCE_NS = 50000000;

/* A batch that is aimed more than a degree off the gaze is not worth finishing. */
static const float STALE_COSINE = 0.99985f;

struct dmn_gaze {
    struct trk_source *source; /* read by one thread; trk_push() and trk_interrupt() by any */
    bool waits_after_end, virtual_clock;
    pthread_t thread;
    bool started;
    atomic_bool stop;
    atomic_bool stale; /* the gaze has left the aim of the painter's batch */
    void (*wake)(void *context);
    void *context;
    struct dmn_recording recording;

    pthread_mutex_t lock; /* of all that follows */
    struct trk_attention *attention;
    struct trk_aim decision; /* the last */
    uint64_t decided_ns;     /* when it was decided */
    struct rnd_aim aim;
    float taken[3];    /* the direction that the painter's batch is aimed at */
    float measured[3]; /* the last gaze, and whether the newest sample has one */
    bool has_gaze;
    bool frozen, ended;
    bool has_view, is_head; /* a client steers, and by the pose of a head */
    struct trk_view view;   /* its view */
    uint64_t samples, valid;
    struct trk_status status;
    bool has_rotation; /* a rotation for eye trackers was kept at an earlier start */
    bool recentred;    /* a device was seen, and the rotation, if there is one, is in use */
    float rotation[4];
    uint64_t count;                    /* samples and decisions for clients so far: */
    struct dmn_gaze_sample kept[KEPT]; /* number n is at n % KEPT */
};

/* Path of the recording that comes with fovead: beside an installed program, else in the source tree. */
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

static bool open_source(struct dmn_gaze *gaze, const struct dmn_options *options,
                        char out_error[TRK_ERROR_SIZE])
{
    char buffer[4096];
    const struct trk_source_kind *kind = trk_source_kind_find(options->gaze);
    struct trk_source_options source = {.spec = options->gaze,
                                        .screen = options->screen,
                                        .calibration = options->calibration,
                                        .fallback_log = shipped_log(buffer, sizeof(buffer)),
                                        .speed = options->speed,
                                        .loop = options->loop,
                                        .virtual_clock = options->virtual_clock};
    struct trk_attention_options attention = {.raw = options->raw_gaze, .predict = options->predict};

    if (options->calibration && access(options->calibration, R_OK)) {
        snprintf(out_error, TRK_ERROR_SIZE, "%.400s: %s", options->calibration, strerror(errno));
        return false;
    }
    if (!(gaze->source = trk_open(&source, out_error))) return false;
    gaze->waits_after_end = kind->waits_after_end;
    if (!kind->follows_eye) attention.raw = true; /* the gaze is where its user points */
    attention.silence_is_rest = kind->rests_when_silent;
    if (!(gaze->attention = trk_attention_create(&attention))) {
        snprintf(out_error, TRK_ERROR_SIZE, "out of memory");
        return false;
    }
    trk_get_status(gaze->source, &gaze->status);
    /* The rotation corrects a headset that has slipped. It is not for recorded logs. */
    gaze->has_rotation = kind->is_device && !options->virtual_clock && dmn_recentring_load(gaze->rotation);
    return true;
}

struct dmn_gaze *dmn_gaze_open(const struct dmn_options *options, char out_error[TRK_ERROR_SIZE])
{
    struct dmn_gaze *gaze = calloc(1, sizeof(*gaze));
    char text[DMN_TEXT_SIZE];

    if (!gaze) {
        snprintf(out_error, TRK_ERROR_SIZE, "out of memory");
        return NULL;
    }
    pthread_mutex_init(&gaze->lock, NULL);
    dmn_recording_init(&gaze->recording);
    gaze->virtual_clock = options->virtual_clock;
    gaze->ended = !options->gaze;
    gaze->aim = (struct rnd_aim){.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}};
    gaze->measured[2] = -1;
    memcpy(gaze->aim.fov, options->fov, sizeof(gaze->aim.fov));
    gaze->aim.pixels_per_degree = options->display_ppd;
    strcpy(gaze->status.description, "none");
    if (options->gaze && !open_source(gaze, options, out_error)) goto fail;
    if (options->record && !dmn_gaze_record(gaze, options->record, options->replace, text)) {
        snprintf(out_error, TRK_ERROR_SIZE, "%.500s", text);
        goto fail;
    }
    return gaze;
fail:
    dmn_gaze_close(gaze);
    return NULL;
}

void dmn_gaze_close(struct dmn_gaze *gaze)
{
    if (!gaze) return;
    dmn_recording_finish(&gaze->recording);
    trk_attention_destroy(gaze->attention);
    trk_close(gaze->source);
    pthread_mutex_destroy(&gaze->lock);
    free(gaze);
}

/* --- decisions: with the lock held --- */

/* The viewport while no client steers. It is where the head points, or, while the head pose is unknown, where
 * the eyes look. It stays while a lid is down or no eye is seen. A screen is straight ahead. */
static void take_viewport(struct dmn_gaze *gaze, const struct trk_sample *sample)
{
    static const float forward[4] = {0, 0, 0, 1};

    if (gaze->frozen) return;
    if (gaze->status.on_screen)
        memcpy(gaze->aim.view, forward, sizeof(gaze->aim.view));
    else if (sample->valid & TRK_HEAD)
        memcpy(gaze->aim.view, sample->head + 3, sizeof(gaze->aim.view));
    else if (gaze->has_gaze && gaze->decision.state < TRK_BLINK)
        dmn_orientation(gaze->measured, gaze->aim.view);
}

static void keep(struct dmn_gaze *gaze, const struct trk_sample *sample_or_null)
{
    const struct dmn_gaze_sample *last = &gaze->kept[gaze->count % KEPT];
    struct dmn_gaze_sample next = *last;

    if (sample_or_null) {
        next.sequence = sample_or_null->sequence;
        next.device_ns = sample_or_null->device_ns;
        next.sensor_ns = sample_or_null->sensor_ns;
        next.arrival_ns = sample_or_null->arrival_ns;
        next.valid = gaze->has_gaze;
        next.has_head = sample_or_null->valid & TRK_HEAD;
        memcpy(next.head, sample_or_null->head + 3, sizeof(next.head));
    }
    memcpy(next.direction, gaze->measured, sizeof(next.direction));
    next.frozen = gaze->frozen;
    next.decision = gaze->decision;
    gaze->kept[++gaze->count % KEPT] = next;
}

/* Decide the aim. True if clients should be told. */
static bool decide(struct dmn_gaze *gaze, const struct trk_sample *sample_or_null, uint64_t now_ns)
{
    struct trk_aim before = gaze->decision, *now = &gaze->decision;

    trk_attend(gaze->attention, sample_or_null, now_ns, now);
    gaze->decided_ns = now_ns;
    if (now->moved) {
        memcpy(gaze->aim.gaze, now->direction, sizeof(gaze->aim.gaze));
        gaze->aim.spread = now->spread;
        if (!gaze->virtual_clock && glm_vec3_dot(gaze->aim.gaze, gaze->taken) < STALE_COSINE)
            atomic_store_explicit(&gaze->stale, true, memory_order_relaxed);
    }
    /* The aim answers a sample even if the sample does not move it; a frozen aim answers none. */
    if (now->moved || (sample_or_null && !gaze->frozen)) {
        gaze->aim.sequence = now->sequence;
        gaze->aim.time_ns = sample_or_null ? sample_or_null->arrival_ns : now_ns;
    }
    if (!sample_or_null && !now->moved && now->state == before.state && now->why == before.why) return false;
    keep(gaze, sample_or_null);
    return true;
}

/* Take the gaze as measured, at a screen through the view of the client that steers. False if there is none.
 */
static bool measure(struct dmn_gaze *gaze, const struct trk_sample *sample)
{
    float head[3];

    if (!gaze->has_view || !(sample->valid & TRK_SCREEN)) return trk_world_direction(sample, gaze->measured);
    return trk_gaze_direction(sample, head, NULL) &&
           trk_view_direction(&gaze->view, sample->screen, gaze->measured);
}

/* An eye tracker in a headset that tells no head pose has that of the headset that steers. */
static void add_head(const struct dmn_gaze *gaze, struct trk_sample *sample)
{
    if (!gaze->is_head || !gaze->status.is_device || gaze->status.on_screen || (sample->valid & TRK_HEAD))
        return;
    memset(sample->head, 0, sizeof(sample->head));
    memcpy(sample->head + 3, gaze->view.orientation, sizeof(gaze->view.orientation));
    sample->valid |= TRK_HEAD;
}

static void accept(struct dmn_gaze *gaze, struct trk_sample *sample, uint64_t now_ns)
{
    add_head(gaze, sample);
    dmn_recording_append(&gaze->recording, sample);
    if (gaze->status.on_screen) trk_drop_head(sample);
    gaze->has_gaze = measure(gaze, sample);
    gaze->ended = false;
    gaze->samples++;
    gaze->valid += gaze->has_gaze;
    decide(gaze, sample, now_ns);
    take_viewport(gaze, sample);
}

/* Follow changes of the source: auto takes up eye trackers, and eye trackers come and go. */
static void note_status(struct dmn_gaze *gaze, const struct trk_status *status)
{
    static const float none[4] = {0, 0, 0, 1};

    if (status->changes != gaze->status.changes) dmn_print(stderr, "fovead: gaze: %s\n", status->description);
    gaze->status = *status;
    trk_attention_pace(gaze->attention, status->speed);
    if (!status->is_device || gaze->recentred) return;
    gaze->recentred = true;
    trk_recentre_set(gaze->attention, gaze->has_rotation ? gaze->rotation : none);
}

/* --- the source --- */

/* Read one sample. True while more may come. *out_news: clients should be told. */
static bool read_one(struct dmn_gaze *gaze, uint64_t until_ns, enum trk_result *out_result, bool *out_news)
{
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    struct trk_status status;
    uint64_t now_ns;
    bool more;

    *out_result = trk_read(gaze->source, until_ns, &sample, error);
    trk_get_status(gaze->source, &status);
    now_ns = !gaze->virtual_clock ? dmn_now_ns() : *out_result == TRK_SAMPLE ? sample.arrival_ns : until_ns;
    pthread_mutex_lock(&gaze->lock);
    /* When a replay has ended, the aim stays where the replay left it, until a tracker sees an eye. */
    if (*out_result == TRK_SAMPLE || (*out_result == TRK_TIMEOUT && !gaze->ended)) note_status(gaze, &status);
    more = *out_result == TRK_SAMPLE || *out_result == TRK_TIMEOUT ||
           (*out_result == TRK_END && gaze->waits_after_end && !gaze->ended);
    *out_news = true;
    if (*out_result == TRK_SAMPLE)
        accept(gaze, &sample, now_ns);
    else if (*out_result != TRK_TIMEOUT)
        gaze->ended = true; /* the end is not taken for silence: the aim stays where it was */
    else
        *out_news = !gaze->ended && decide(gaze, NULL, now_ns);
    pthread_mutex_unlock(&gaze->lock);
    if (*out_result == TRK_FAILED) dmn_print(stderr, "fovead: gaze: %s; it stays where it was\n", error);
    return more;
}

static void *read_all(void *argument)
{
    struct dmn_gaze *gaze = argument;
    enum trk_result result;
    bool news;

    trk_be_prompt();
    while (!atomic_load(&gaze->stop) && read_one(gaze, dmn_now_ns() + PATIENCE_NS, &result, &news))
        if (news) gaze->wake(gaze->context);
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
    bool news;

    while (!gaze->ended && result == TRK_SAMPLE && read_one(gaze, now_ns, &result, &news)) continue;
}

/* --- for whoever asks --- */

void dmn_gaze_aim(struct dmn_gaze *gaze, struct rnd_aim *out_aim)
{
    pthread_mutex_lock(&gaze->lock);
    *out_aim = gaze->aim;
    out_aim->stale = &gaze->stale;
    memcpy(gaze->taken, gaze->aim.gaze, sizeof(gaze->taken));
    atomic_store_explicit(&gaze->stale, false, memory_order_relaxed);
    if (gaze->has_view) {
        memcpy(out_aim->view, gaze->view.orientation, sizeof(out_aim->view));
        memcpy(out_aim->fov, gaze->view.fov, sizeof(out_aim->fov));
    }
    pthread_mutex_unlock(&gaze->lock);
}

void dmn_gaze_status(struct dmn_gaze *gaze, struct dmn_gaze_status *out_status)
{
    struct trk_recorder_status recorder;

    pthread_mutex_lock(&gaze->lock);
    *out_status = (struct dmn_gaze_status){
        .samples = gaze->samples,
        .valid = gaze->valid,
        .frozen = gaze->frozen,
        .ended = gaze->ended,
        .source = gaze->status,
    };
    memcpy(out_status->direction, gaze->aim.gaze, sizeof(out_status->direction));
    pthread_mutex_unlock(&gaze->lock);
    dmn_recording_tell(&gaze->recording, out_status->recording, &recorder);
    out_status->recorded = recorder.written;
    out_status->lost = recorder.lost;
    out_status->recording_fails = recorder.failing;
    memcpy(out_status->recording_error, recorder.error, sizeof(out_status->recording_error));
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

/* --- what clients ask for --- */

void dmn_gaze_freeze(struct dmn_gaze *gaze, bool frozen)
{
    pthread_mutex_lock(&gaze->lock);
    gaze->frozen = frozen;
    if (gaze->attention) {
        trk_attention_freeze(gaze->attention, frozen);
        decide(gaze, NULL, gaze->decided_ns); /* at once, and without time passing */
    }
    pthread_mutex_unlock(&gaze->lock);
    if (gaze->wake) gaze->wake(gaze->context);
}

void dmn_gaze_push(struct dmn_gaze *gaze, const float direction[3])
{
    if (gaze->source) trk_push(gaze->source, direction, dmn_now_ns());
}

void dmn_gaze_view(struct dmn_gaze *gaze, const struct trk_view *view_or_null, bool is_head)
{
    uint64_t now_ns = dmn_now_ns();

    pthread_mutex_lock(&gaze->lock);
    gaze->has_view = view_or_null;
    gaze->is_head = view_or_null && is_head;
    if (view_or_null) gaze->view = *view_or_null;
    if (gaze->attention) {
        trk_attention_view(gaze->attention, view_or_null);
        /* At once: an eye that rests on the screen now sees something else. After the end no time passes. */
        if (decide(gaze, NULL, gaze->ended ? gaze->decided_ns : now_ns) && gaze->decision.moved)
            gaze->aim.time_ns = now_ns;
    }
    pthread_mutex_unlock(&gaze->lock);
}

bool dmn_gaze_recentre(struct dmn_gaze *gaze, const float *target_or_null, char out_text[DMN_TEXT_SIZE])
{
    char error[TRK_ERROR_SIZE] = "recentre: there is no gaze";
    float rotation[4] = {0, 0, 0, 1};
    bool good, device;
    double turn_deg;
    size_t length;

    pthread_mutex_lock(&gaze->lock);
    good = gaze->attention && trk_recentre(gaze->attention, target_or_null, error);
    if (good) trk_recentre_get(gaze->attention, rotation);
    device = gaze->status.is_device;
    pthread_mutex_unlock(&gaze->lock);
    if (!good) {
        snprintf(out_text, DMN_TEXT_SIZE, "%s", error);
        return false;
    }
    turn_deg = 2 * acos(fmin(1, fabs((double)rotation[3]))) * 180 / M_PI;
    length = (size_t)snprintf(out_text, DMN_TEXT_SIZE, "gaze is turned by %.1f degrees", turn_deg);
    if (!device) {
        snprintf(out_text + length, DMN_TEXT_SIZE - length,
                 " until fovead ends: it comes from no eye tracker");
        return true;
    }
    good = dmn_recentring_save(rotation, error);
    snprintf(out_text + length, DMN_TEXT_SIZE - length,
             good ? ", also after the next start%s" : ", but that is not kept: %s", good ? "" : error);
    return good;
}

bool dmn_gaze_record(struct dmn_gaze *gaze, const char *path_or_null, bool replace,
                     char out_text[DMN_TEXT_SIZE])
{
    if (!path_or_null) return dmn_recording_end(&gaze->recording, out_text);
    if (gaze->source) return dmn_recording_begin(&gaze->recording, path_or_null, replace, out_text);
    snprintf(out_text, DMN_TEXT_SIZE, "there is no gaze to record");
    return false;
}
