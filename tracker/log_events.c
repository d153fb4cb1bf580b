/* Finds the events of a whole log. Every sample gets a label, later samples correct the labels of earlier
 * ones, and each run of equal labels is an event. */
#include "events.h"
#include "gaze.h"

#include "arc.h"

#include <stdlib.h>
#include <string.h>

enum { NEAR = 3 }; /* how many samples are averaged at each end of a saccade */

struct scan {
    const struct trk_log *log;
    size_t count;
    unsigned char *label; /* one trk_state per sample; TRK_FALLBACK: no gaze */
    float (*world)[3];    /* gaze in the world; all 0 if there is none */
};

static bool seen(const struct scan *scan, size_t i)
{
    const float *w = scan->world[i];
    return w[0] != 0 || w[1] != 0 || w[2] != 0;
}

static uint64_t time_of(const struct scan *scan, size_t i)
{
    return trk_log_time(scan->log, i);
}

/* Extend a saccade backwards over samples in which the eye was already moving before the onset showed. */
static void backdate(struct scan *scan, const struct trk_classifier *c, size_t onset)
{
    double still_deg = 3 * c->noise_deg;
    for (size_t i = onset; i-- > 0 && onset - i <= NEAR;) {
        if (!seen(scan, i) || scan->label[i] == TRK_SACCADE) return;
        if (trk_angle_deg(scan->world[i], c->from) < still_deg) return;
        scan->label[i] = TRK_SACCADE;
    }
}

static void classify(struct scan *scan, double *out_noise_deg)
{
    struct trk_classifier c;
    size_t last = SIZE_MAX;
    trk_classifier_init(&c);
    for (size_t i = 0; i < scan->count; i++) {
        struct trk_sample sample;
        float head[3];
        trk_log_sample(scan->log, i, &sample);
        scan->label[i] = TRK_FALLBACK;
        if (!trk_gaze_direction(&sample, head, NULL)) continue;
        trk_to_world(&sample, head, scan->world[i]);
        enum trk_state before = c.state;
        bool later = last == SIZE_MAX || time_of(scan, i) > time_of(scan, last);
        scan->label[i] = later ? trk_classify(&c, time_of(scan, i), head, scan->world[i]) : c.state;
        if (c.state == TRK_SACCADE && before != TRK_SACCADE) backdate(scan, &c, i);
        if (c.state != TRK_SACCADE && before == TRK_SACCADE && last != SIZE_MAX && c.count > 1)
            scan->label[last] = c.state; /* it was already at rest */
        last = i;
    }
    *out_noise_deg = c.noise_deg;
}

/* Mean direction of up to NEAR samples with gaze, from i on, in steps of +1 or -1. */
static bool mean_from(const struct scan *scan, size_t i, int step, float out[3])
{
    vec3 sum = {0};
    int n = 0;
    for (; i < scan->count && n < NEAR; i += (size_t)step) {
        if (!seen(scan, i) || (n && scan->label[i] == TRK_SACCADE)) break;
        glm_vec3_add(sum, scan->world[i], sum);
        n++;
    }
    if (!n) return false;
    glm_vec3_normalize_to(sum, out);
    return true;
}

/* No eye is seen from sample first to sample last: bridge the gap, or label it as a blink or a loss. */
static void name_gap(struct scan *scan, size_t first, size_t last)
{
    uint64_t start_ns = time_of(scan, first ? first - 1 : first);
    uint64_t end_ns = time_of(scan, last + 1 < scan->count ? last + 1 : last), gap_ns = end_ns - start_ns;
    unsigned char label = gap_ns <= TRK_LONGEST_BLINK_NS ? TRK_BLINK : TRK_LOST;
    size_t open = 0, closed = 0;
    for (size_t i = first; i <= last; i++) {
        struct trk_sample sample;
        trk_log_sample(scan->log, i, &sample);
        bool known, shut = trk_lids_closed(&sample, &known);
        closed += shut;
        open += known && !shut;
    }
    if (closed)
        label = gap_ns <= TRK_LONGEST_BLINK_NS || closed > open ? TRK_BLINK : TRK_LOST;
    else if (open)
        label = TRK_LOST;
    if (gap_ns < TRK_BRIDGED_NS && !closed && first > 0 && last + 1 < scan->count) {
        float from[3], to[3];
        bool jumped = mean_from(scan, first - 1, -1, from) && mean_from(scan, last + 1, 1, to) &&
                      trk_angle_deg(from, to) > TRK_MERGED_DEG;
        label = jumped ? TRK_SACCADE : scan->label[first - 1];
    }
    memset(scan->label + first, label, last - first + 1);
}

static void name_gaps(struct scan *scan)
{
    for (size_t i = 0; i < scan->count; i++) {
        if (scan->label[i] != TRK_FALLBACK) continue;
        size_t last = i;
        while (last + 1 < scan->count && scan->label[last + 1] == TRK_FALLBACK) last++;
        name_gap(scan, i, last);
        i = last;
    }
}

static size_t run_end(const struct scan *scan, size_t first)
{
    size_t last = first;
    while (last + 1 < scan->count && scan->label[last + 1] == scan->label[first] &&
           time_of(scan, last + 1) - time_of(scan, last) < TRK_BRIDGED_NS)
        last++;
    return last;
}

/* Extend blinks over the samples that the moving lid disturbs, but not over other blinks or losses. */
static void widen_blinks(struct scan *scan)
{
    for (size_t i = 0; i < scan->count; i++) {
        if (scan->label[i] != TRK_BLINK) continue;
        size_t last = run_end(scan, i);
        uint64_t start_ns = time_of(scan, i), end_ns = time_of(scan, last);
        for (size_t k = i; k-- > 0 && start_ns - time_of(scan, k) <= TRK_BEFORE_BLINK_NS && seen(scan, k);)
            scan->label[k] = TRK_BLINK;
        for (; last + 1 < scan->count && seen(scan, last + 1); last++) {
            if (time_of(scan, last + 1) - end_ns > TRK_AFTER_BLINK_NS) break;
            scan->label[last + 1] = TRK_BLINK;
        }
        i = last;
    }
}

/* A saccade that ends where it began belongs to the fixation around it. */
static void dissolve_jitter(struct scan *scan)
{
    for (size_t i = 0; i < scan->count; i++) {
        if (scan->label[i] != TRK_SACCADE) continue;
        size_t last = run_end(scan, i);
        float from[3], to[3];
        if (i > 0 && scan->label[i - 1] == TRK_FIXATION && mean_from(scan, i - 1, -1, from) &&
            mean_from(scan, last + 1, 1, to) && trk_angle_deg(from, to) < TRK_LEAST_JUMP_DEG)
            memset(scan->label + i, TRK_FIXATION, last - i + 1);
        i = last;
    }
}

/* The direction of a fixation is its mean. That of another event is the gaze at its end, for a saccade in the
 * samples that follow it. */
static void find_direction(const struct scan *scan, struct trk_event *event)
{
    const bool jump = event->type == TRK_SACCADE;
    vec3 sum = {0};
    if (event->type != TRK_FIXATION) {
        mean_from(scan, jump ? event->last + 1 : event->last, jump ? 1 : -1, event->direction);
        return;
    }
    for (size_t i = event->first; i <= event->last; i++) glm_vec3_add(sum, scan->world[i], sum);
    glm_vec3_normalize_to(sum, event->direction);
}

/* List the events, and return how many there are. out may be NULL. When the tracker sends nothing between two
 * samples, that is a loss without samples of its own. */
static size_t list(const struct scan *scan, struct trk_event *out)
{
    size_t count = 0;
    for (size_t i = 0, last; i < scan->count; i = last + 1) {
        last = run_end(scan, i);
        uint64_t next_ns = time_of(scan, last + 1 < scan->count ? last + 1 : last);
        bool silence = next_ns - time_of(scan, last) >= TRK_BRIDGED_NS;
        struct trk_event event = {.type = (enum trk_state)scan->label[i],
                                  .start_ns = time_of(scan, i),
                                  .end_ns = silence ? time_of(scan, last) : next_ns,
                                  .first = i,
                                  .last = last};
        if (event.type != TRK_FIXATION || event.end_ns - event.start_ns >= TRK_LEAST_FIXATION_NS) {
            if (out) find_direction(scan, &event), out[count] = event;
            count++;
        }
        if (silence && out)
            out[count] = (struct trk_event){.type = TRK_LOST,
                                            .start_ns = event.end_ns,
                                            .end_ns = next_ns,
                                            .first = last,
                                            .last = last + 1};
        count += silence;
    }
    return count;
}

bool trk_events_find(const struct trk_log *log, struct trk_events *out_events)
{
    size_t n = log->count ? log->count : 1;
    struct scan scan = {.log = log,
                        .count = log->count,
                        .label = calloc(n, sizeof *scan.label),
                        .world = calloc(n, sizeof *scan.world)};
    *out_events = (struct trk_events){0};
    bool ok = scan.label && scan.world;
    if (ok) {
        classify(&scan, &out_events->noise_deg);
        name_gaps(&scan);
        dissolve_jitter(&scan);
        widen_blinks(&scan);
        out_events->count = list(&scan, NULL);
        out_events->events = calloc(out_events->count + 1, sizeof *out_events->events);
        ok = out_events->events;
    }
    if (ok) list(&scan, out_events->events);
    for (size_t i = 0; ok && i < out_events->count; i++) out_events->counts[out_events->events[i].type]++;
    if (!ok) out_events->count = 0;
    free(scan.world);
    free(scan.label);
    return ok;
}

void trk_events_finish(struct trk_events *events)
{
    free(events->events);
    *events = (struct trk_events){0};
}
