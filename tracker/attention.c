/* From gaze to aim: classify and filter the gaze; hold, widen or give up the aim without gaze.
 *
 * Only this file decides where to aim while there is no gaze, and when the aim stays in place. events.c
 * classifies what the eye does; filter.c smooths the gaze. The caller passes the time to every call, so that
 * a replay leads to the same decisions as the live stream did. */
#include "tracker.h"

#include "arc.h"
#include "error.h"
#include "events.h"
#include "filter.h"
#include "gaze.h"
#include "view.h"

#include <stdlib.h>
#include <string.h>

#define MS UINT64_C(1000000)

/* The aim is held through a blink. An interruption of more than 500 ms counts as a loss, and the fovea
 * widens. After 2 s without gaze the eye may look anywhere; the centre of the view is the likeliest place. */
static const uint64_t held_ns = 500 * MS, given_up_ns = 2000 * MS;
static const double widest = 4;
/* During a fixation the aim stays as long as gaze is nearer to it than 1 degree, or than three standard
 * deviations of the noise if that is more. */
static const double dead_zone_deg = 1, dead_zone_noises = 3;
/* Main sequence of saccades, Dai et al. 2016: Vp = eta (1 - exp(-A / c)). Above 0.96 eta its inverse is
 * useless, because there 25 deg/s of noise change the amplitude by 6 degrees. So the longest predicted
 * saccade is 19 degrees. */
static const double saccade_eta = 600, saccade_c = 6, invertible = 0.96;
static const double largest_turn_deg = 20;

struct trk_attention {
    struct trk_attention_options options;
    struct trk_classifier classifier;
    struct trk_filter filter;
    versor rotation; /* the correction by recentring, in the head frame */

    bool has_sample, has_gaze;
    struct trk_sample sample;     /* the newest */
    uint64_t heard_ns;            /* now_ns when the newest sample came; silence counts from it */
    double speed;                 /* of the device's clock relative to now_ns */
    uint64_t gaze_ns;             /* device time of the newest sample with a gaze */
    bool hidden;                  /* the newest sample has no gaze */
    bool lids_known, lids_closed; /* what samples without gaze say of the lids */
    bool settling;                /* the eye has just reopened; its gaze is not trusted yet */
    uint64_t reopened_ns;         /* when the eye reopened, in device time */

    bool has_view;
    struct trk_view view;
    /* Gaze is a point on the screen with the view: the directions of classifier and filter are those from a
     * desk (view.h). */
    bool by_screen;
    bool aims_by_screen; /* and so is live.direction */
    bool frozen;
    bool pinned;         /* the aim rests on a fixation */
    struct trk_aim live; /* what the aim is without freezing */
    struct trk_aim last; /* the last answer */
};

struct trk_attention *trk_attention_create(const struct trk_attention_options *options)
{
    /* aligned_alloc(), because versors need a stricter alignment than calloc() guarantees */
    struct trk_attention *a = aligned_alloc(_Alignof(struct trk_attention), sizeof *a);
    if (!a) return NULL;
    *a = (struct trk_attention){.options = *options, .speed = 1};
    trk_classifier_init(&a->classifier);
    glm_quat_identity(a->rotation);
    a->live = (struct trk_aim){.direction = {0, 0, -1}, .spread = 1, .state = TRK_FALLBACK};
    a->last = a->live;
    return a;
}

void trk_attention_destroy(struct trk_attention *attention)
{
    free(attention);
}

/* --- one sample --- */

static void begin_anew(struct trk_attention *a)
{
    a->classifier.count = 0;
    trk_filter_reset(&a->filter);
    a->pinned = false;
}

/* Filter the gaze in the world frame, because there gaze rests while the head turns. Saccades are not
 * filtered: the filter starts again with the last sample of a saccade, at which the eye already rests. It
 * also starts again after a gap, because the eye may be elsewhere. */
static void smooth(struct trk_attention *a, uint64_t device_ns, const float world[3])
{
    struct trk_classifier *c = &a->classifier;
    double dt_s = (double)(device_ns - a->gaze_ns) * 1e-9;
    if (a->options.raw || c->state == TRK_SACCADE || c->count == 1) trk_filter_reset(&a->filter);
    trk_filter_step(&a->filter, world, dt_s);
}

/* Predict where a saccade will land: in its direction, at the amplitude that the main sequence gives for its
 * peak speed so far, but not short of where it is. */
static void predict(struct trk_attention *a, const float world[3], float out_world[3])
{
    vec3 arc;
    trk_arc(a->classifier.from, world, arc);
    double peak = fmin(a->classifier.peak_deg_s, invertible * saccade_eta);
    double amplitude_deg = -saccade_c * log(1 - peak / saccade_eta);
    if (amplitude_deg > glm_vec3_norm(arc)) glm_vec3_scale_as(arc, (float)amplitude_deg, arc);
    trk_along(a->classifier.from, arc, out_world);
}

/* Can the gaze of an eye that has reopened be trusted? It can once gaze has rested for three samples, or
 * after so much time that the lid must be up. */
static bool is_settled(const struct trk_attention *a)
{
    const struct trk_classifier *c = &a->classifier;
    if (a->sample.device_ns - a->reopened_ns >= TRK_AFTER_BLINK_NS) return true;
    return c->state == TRK_FIXATION && c->count >= 3 &&
           trk_angle_deg(a->filter.value, a->filter.raw) < fmax(TRK_LEAST_JUMP_DEG, 3 * c->noise_deg);
}

/* Aim at a gaze. The aim stays if gaze only trembles around it. */
static void aim_at(struct trk_attention *a, const float world[3], const char *source)
{
    const struct trk_classifier *c = &a->classifier;
    const bool predicted = a->options.predict && c->state == TRK_SACCADE;
    const uint64_t age_ns = a->sample.device_ns - c->since_ns;
    float target[3];
    memcpy(target, a->filter.value, sizeof target);
    if (predicted) predict(a, world, target);

    bool pins = c->state == TRK_FIXATION && age_ns >= TRK_LEAST_FIXATION_NS && !a->options.raw;
    double zone_deg = fmax(dead_zone_deg, dead_zone_noises * c->noise_deg);
    bool rests = pins && a->pinned && trk_angle_deg(target, a->live.direction) <= zone_deg;
    if (!rests) memcpy(a->live.direction, target, sizeof target);
    a->pinned = pins;
    a->aims_by_screen = a->by_screen;
    a->live.source = predicted ? "prediction" : source;
    a->live.state = c->state;
    a->live.why = rests                     ? "within the dead zone of a fixation"
                  : predicted               ? "landing of a saccade by its speed"
                  : c->state == TRK_SACCADE ? "as measured in a saccade"
                  : c->state == TRK_PURSUIT ? "filtered, in pursuit"
                  : pins && !a->options.raw ? "filtered, new aim in a fixation"
                  : a->options.raw          ? "as measured"
                                            : "filtered, after a saccade";
}

static void view_centre(const struct trk_attention *a, float out[3])
{
    static const float forward[3] = {0, 0, -1};
    if (a->has_sample && (a->sample.valid & TRK_HEAD) && !a->by_screen) {
        trk_to_world(&a->sample, forward, out);
        return;
    }
    vec3 direction = {0, 0, -1};
    versor view = GLM_QUAT_IDENTITY_INIT;
    if (a->has_view) memcpy(view, a->view.orientation, sizeof view);
    glm_quat_rotatev(view, direction, direction);
    memcpy(out, direction, sizeof direction);
}

/* Hold the aim while the eye looks beside the view: where it was in the view, if it was there before. */
static void look_away(struct trk_attention *a)
{
    if (!a->aims_by_screen) view_centre(a, a->live.direction);
    a->pinned = false;
    a->live.state = a->classifier.state;
    a->live.source = a->aims_by_screen ? "last gaze" : "view centre";
    a->live.why = "the eye looks beside the view";
}

/* Does the eye look at the screen beside the view, in that direction from the desk? */
static bool is_beside(const struct trk_attention *a, const float desk[3])
{
    float point[2];
    trk_desk_point(desk, point);
    return !trk_view_shows(&a->view, point);
}

static void see(struct trk_attention *a, const float head[3], const char *source)
{
    const struct trk_sample *sample = &a->sample;
    const bool again = a->has_gaze && sample->device_ns == a->gaze_ns;
    const bool gap = a->has_gaze && sample->device_ns - a->gaze_ns >= TRK_BRIDGED_NS;
    float world[3];
    if (a->by_screen)
        memcpy(world, head, sizeof world);
    else
        trk_to_world(sample, head, world);
    if (again) return; /* the device repeats a sample */
    if ((gap || a->lids_closed) && a->hidden && !a->options.silence_is_rest) {
        a->settling = true;
        a->reopened_ns = sample->device_ns;
    }
    if (!a->has_gaze) a->classifier.count = 0;
    trk_classify(&a->classifier, sample->device_ns, head, world);
    smooth(a, sample->device_ns, world);
    a->hidden = a->lids_closed = false;
    a->has_gaze = true;
    a->gaze_ns = sample->device_ns;
    if (a->settling && is_settled(a)) a->settling = a->pinned = false;
    if (a->settling) {
        a->live.state = TRK_BLINK;
        a->live.source = "last gaze";
        a->live.why = "the eye has just reopened";
        return;
    }
    a->live.spread = 1;
    if (a->by_screen && is_beside(a, head))
        look_away(a);
    else
        aim_at(a, world, source);
}

/* Choose the frame of the sample's gaze. Another one begins anew. */
static void choose_frame(struct trk_attention *a)
{
    const bool by_screen = a->has_view && (a->sample.valid & TRK_SCREEN);
    if (by_screen != a->by_screen) begin_anew(a);
    a->by_screen = by_screen;
}

static void take(struct trk_attention *a, const struct trk_sample *sample, uint64_t now_ns)
{
    float head[3];
    const char *source;
    if (a->has_sample &&
        sample->device_ns < a->sample.device_ns) { /* another device, or its clock restarted */
        begin_anew(a);
        a->has_gaze = false;
        a->gaze_ns = sample->device_ns;
    }
    a->sample = *sample;
    a->heard_ns = now_ns;
    a->has_sample = true;
    a->live.sequence = sample->sequence;
    a->live.device_ns = sample->device_ns;
    a->live.sensor_ns = sample->sensor_ns;
    a->live.arrival_ns = sample->arrival_ns;
    if (trk_gaze_direction(sample, head, &source)) {
        choose_frame(a);
        if (a->by_screen) trk_desk_direction(sample->screen, head);
        vec3 turned = {head[0], head[1], head[2]};
        glm_quat_rotatev(a->rotation, turned, turned);
        see(a, turned, source);
        return;
    }
    bool known;
    a->hidden = true;
    a->lids_closed |= trk_lids_closed(sample, &known);
    a->lids_known = known;
}

/* --- without gaze --- */

static void give_up(struct trk_attention *a, const char *why)
{
    view_centre(a, a->live.direction);
    a->aims_by_screen = false;
    a->live.state = TRK_FALLBACK;
    a->live.source = "view centre";
    a->live.why = why;
    a->live.spread = a->options.silence_is_rest ? 1 : (float)widest;
    a->pinned = false;
}

/* The time since the last sample came, on the device's clock. */
static uint64_t silence_ns(const struct trk_attention *a, uint64_t now_ns)
{
    if (now_ns <= a->heard_ns) return 0;
    return (uint64_t)fmin((double)(now_ns - a->heard_ns) * a->speed, 0x1p62);
}

/* Let time pass: hold, widen or give up the aim if no eye is seen, because the newest sample shows none or
 * because no samples come. */
static void pass_time(struct trk_attention *a, uint64_t now_ns)
{
    if (!a->has_gaze && a->live.state == TRK_FALLBACK) {
        give_up(a, "no gaze was seen yet");
        return;
    }
    bool silent = silence_ns(a, now_ns) >= TRK_BRIDGED_NS && !a->options.silence_is_rest;
    if (!a->hidden && !silent) return;
    uint64_t lost_ns = a->sample.device_ns - a->gaze_ns + silence_ns(a, now_ns);
    if (lost_ns >= given_up_ns) {
        give_up(a, "no gaze was seen for two seconds");
        return;
    }
    a->hidden = true;
    a->live.source = "last gaze";
    if (lost_ns > held_ns)
        a->live.spread =
            (float)(1 + (widest - 1) * (double)(lost_ns - held_ns) / (double)(given_up_ns - held_ns));
    if (silent || lost_ns > TRK_LONGEST_BLINK_NS || (lost_ns > held_ns && !a->lids_closed)) {
        a->live.state = TRK_LOST;
        a->live.why = silent ? "the tracker is silent" : "no eye is seen";
    } else if (a->lids_closed) {
        a->live.state = TRK_BLINK;
        a->live.why = "the lids are down";
    } else if (lost_ns < TRK_BRIDGED_NS) {
        a->live.why = "a short gap";
    } else {
        a->live.state = a->lids_known ? TRK_LOST : TRK_BLINK;
        a->live.why = a->lids_known ? "no eye is seen, though the lids are up" : "taken for a blink";
    }
}

/* --- the answer --- */

/* The aim, in the world. */
static void aim_in_world(const struct trk_attention *a, float out_world[3])
{
    float point[2];
    memcpy(out_world, a->live.direction, sizeof a->live.direction);
    if (!a->aims_by_screen) return;
    trk_desk_point(a->live.direction, point);
    trk_view_nearest(&a->view, point, out_world);
}

void trk_attend(struct trk_attention *a, const struct trk_sample *sample_or_null, uint64_t now_ns,
                struct trk_aim *out_aim)
{
    if (sample_or_null) take(a, sample_or_null, now_ns);
    pass_time(a, now_ns);
    struct trk_aim aim = a->live;
    aim_in_world(a, aim.direction);
    if (a->frozen) {
        memcpy(aim.direction, a->last.direction, sizeof aim.direction);
        aim.spread = a->last.spread;
        aim.state = TRK_FROZEN;
        aim.source = "last gaze";
        aim.why = "frozen";
    }
    aim.time_ns = now_ns;
    aim.noise_deg = (float)a->classifier.noise_deg;
    aim.moved =
        aim.spread != a->last.spread || memcmp(aim.direction, a->last.direction, sizeof aim.direction) != 0;
    a->last = *out_aim = aim;
}

void trk_attention_freeze(struct trk_attention *attention, bool frozen)
{
    attention->frozen = frozen;
}

void trk_attention_pace(struct trk_attention *attention, double speed)
{
    attention->speed = speed;
}

void trk_attention_view(struct trk_attention *a, const struct trk_view *view_or_null)
{
    a->has_view = view_or_null;
    if (view_or_null) {
        a->view = *view_or_null;
        return;
    }
    float world[3];
    aim_in_world(a, world);
    memcpy(a->live.direction, world, sizeof world);
    if (a->by_screen) begin_anew(a);
    a->by_screen = a->aims_by_screen = false;
}

/* --- recentring --- */

static double turn_deg(const versor q)
{
    return 2 * glm_deg(atan2f(sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]), fabsf(q[3])));
}

bool trk_recentre_set(struct trk_attention *a, const float rotation[4])
{
    versor q;
    memcpy(q, rotation, sizeof q);
    if (!(fabsf(glm_quat_norm(q) - 1) <= 1e-3f) || turn_deg(q) > largest_turn_deg) return false;
    glm_quat_normalize_to(q, a->rotation);
    begin_anew(a);
    return true;
}

void trk_recentre_get(const struct trk_attention *attention, float out_rotation[4])
{
    memcpy(out_rotation, attention->rotation, 4 * sizeof *out_rotation);
}

/* Turn a direction from the world to the head frame of the newest sample. */
static void to_head(const struct trk_attention *a, const float world[3], vec3 out_head)
{
    versor head = GLM_QUAT_IDENTITY_INIT;
    vec3 direction = {world[0], world[1], world[2]};
    if (a->sample.valid & TRK_HEAD) memcpy(head, &a->sample.head[3], sizeof head);
    glm_quat_conjugate(head, head);
    glm_quat_rotatev(head, direction, direction);
    glm_vec3_normalize_to(direction, out_head);
}

/* Into the frame of the gaze before it is recentred: that of the desk, or of the head. False: from the desk
 * the direction is not to be seen. */
static bool to_gaze(const struct trk_attention *a, const float world[3], vec3 out)
{
    float point[2];
    if (!a->by_screen) {
        to_head(a, world, out);
        return true;
    }
    if (!trk_view_point(&a->view, world, point)) return false;
    trk_desk_direction(point, out);
    return true;
}

bool trk_recentre(struct trk_attention *a, const float *target_or_null, char out_error[TRK_ERROR_SIZE])
{
    const bool rests = a->has_gaze && a->filter.count > 0 && !a->hidden && !a->settling &&
                       a->classifier.state == TRK_FIXATION &&
                       a->gaze_ns - a->classifier.since_ns >= TRK_LEAST_FIXATION_NS;
    if (!rests)
        return trk_fail(out_error,
                        "recentre: gaze is not at rest (%s), expected a look at the target for 0.1 s",
                        trk_state_name(a->live.state));
    float centre[3];
    vec3 from, to;
    versor back, rotation;
    view_centre(a, centre);
    if (!to_gaze(a, target_or_null ? target_or_null : centre, to))
        return trk_fail(out_error, "recentre: the target is not in the view");
    if (a->by_screen)
        memcpy(from, a->filter.value, sizeof from);
    else
        to_head(a, a->filter.value, from);
    glm_quat_conjugate(a->rotation, back);
    glm_quat_rotatev(back, from, from);
    glm_quat_from_vecs(from, to, rotation);
    if (trk_recentre_set(a, rotation)) return true;
    return trk_fail(out_error, "recentre: gaze is %.0f degrees from the target, expected at most %.0f",
                    trk_angle_deg(from, to), largest_turn_deg);
}
