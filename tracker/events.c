/* The classifier: its constants, speeds, states and noise. */
#include "events.h"

#include "arc.h"

#include <stdlib.h>
#include <string.h>

#define MS UINT64_C(1000000)

/* Speed is the difference between two means, divided by time. The newest span and the base span are averaged;
 * a span between them may be skipped. A speed above least_deg_s in one of the rows is an onset. At 120 Hz,
 * one sample against the three before it shows the onset of a large saccade soonest. One against three with
 * one skipped shows that of a smaller saccade, which also takes about three samples and would otherwise be
 * part of its own base. Two against three with one skipped has less noise, and shows the smallest saccades,
 * of one degree, when they have landed. One against two shows the offset, because it forgets the saccade
 * sooner. One against one gives the peak. */
static const struct span {
    uint64_t newest_ns, skip_ns, base_ns;
    double least_deg_s;
} onset_spans[] = {{6 * MS, 0, 27 * MS, 60}, {6 * MS, 7 * MS, 27 * MS, 40}, {14 * MS, 7 * MS, 27 * MS, 35}},
  offset_span = {6 * MS, 0, 13 * MS, 40}, peak_span = {6 * MS, 0, 5 * MS, 0};
/* All thresholds are above the usual 30 deg/s (Tobii XR Ocumen), because that is less than the noise of a
 * headset: 60 to 120 deg/s from sample to sample at 120 Hz. While gaze already moves, the threshold is 70,
 * because the movement may be a pursuit of 30. All thresholds rise with the measured noise: the measured
 * speed of an eye at rest is Rayleigh distributed, and exceeds 4.5 times its scale once in 25,000 samples,
 * and twice its scale once in seven. */
static const double moving_onset_deg_s = 70, onset_noises = 4.5, offset_noises = 2;
enum { ONSETS = sizeof onset_spans / sizeof *onset_spans };
/* The longest saccades, of 40 degrees, take 110 ms. */
static const uint64_t longest_saccade_ns = 150 * MS;
/* A pursuit begins when the slope over 100 ms has been above 10 deg/s, or above 4 standard deviations of its
 * noise, for another 100 ms. By then the largest step that shows no onset has left the span. It ends at half
 * of that speed. */
static const double pursuit_deg_s = 10, pursuit_noises = 4;
static const uint64_t pursuit_ns = 100 * MS;
/* Samples are missing where more than this, and more than twice the usual interval, has passed. */
static const uint64_t short_gap_ns = 20 * MS;
/* The noise that is assumed at first, and the lowest noise: no tracker is better. */
static const double first_noise_deg = 0.2, least_noise_deg = 0.01;
/* Steps of 0.7 / n find the median soonest, because the density of the logarithm of the noise is 0.7 at the
 * median. Steps stay above a minimum, so that the estimate keeps following. */
static const double first_noise_step = 0.7, least_noise_step = 0.004;

void trk_classifier_init(struct trk_classifier *classifier)
{
    *classifier = (struct trk_classifier){.state = TRK_FIXATION, .noise_deg = first_noise_deg};
}

/* --- speeds --- */

struct mean {
    int count;
    double age_ns; /* age relative to the newest sample */
    vec3 head, world;
};

static const struct trk_past *past(const struct trk_classifier *c, uint64_t age)
{
    return &c->past[(c->count - 1 - age) % TRK_PAST];
}

static uint64_t kept(const struct trk_classifier *c)
{
    return c->count < TRK_PAST ? c->count : TRK_PAST;
}

/* Average the samples from number *age back (0 is the newest) that are less than span_ns older than the
 * newest and not older than not_before_ns; at least one, if there is one. Moves *age past them. */
static void average(const struct trk_classifier *c, uint64_t *age, uint64_t span_ns, uint64_t not_before_ns,
                    struct mean *out)
{
    uint64_t now_ns = past(c, 0)->time_ns;
    *out = (struct mean){0};
    for (; *age < kept(c); ++*age) {
        const struct trk_past *p = past(c, *age);
        if (p->time_ns < not_before_ns || (out->count && now_ns - p->time_ns >= span_ns)) break;
        glm_vec3_add(out->head, (float *)p->head, out->head);
        glm_vec3_add(out->world, (float *)p->world, out->world);
        out->age_ns += (double)(now_ns - p->time_ns);
        out->count++;
    }
    if (!out->count) return;
    glm_vec3_divs(out->head, (float)out->count, out->head);
    glm_vec3_divs(out->world, (float)out->count, out->world);
    out->age_ns /= out->count;
}

/* Speeds in deg/s. All are 0 while there are too few samples. */
struct speed {
    double world, lesser; /* of gaze in the world; the lower of that and the speed in the head */
    double noise;         /* standard deviation of each axis of either speed */
    vec3 from;            /* mean direction of the base span: unit, world */
};

static struct speed speed_over(const struct trk_classifier *c, struct span span, uint64_t not_before_ns)
{
    struct mean newest, skipped, base;
    struct speed speed = {0};
    uint64_t age = 0;
    average(c, &age, span.newest_ns, not_before_ns, &newest);
    if (span.skip_ns) average(c, &age, span.newest_ns + span.skip_ns, not_before_ns, &skipped);
    average(c, &age, span.newest_ns + span.skip_ns + span.base_ns, not_before_ns, &base);
    if (!newest.count || !base.count) return speed;
    double dt_s = (base.age_ns - newest.age_ns) * 1e-9;
    double head = glm_deg(glm_vec3_distance(newest.head, base.head)) / dt_s;
    speed.world = glm_deg(glm_vec3_distance(newest.world, base.world)) / dt_s;
    speed.lesser = fmin(head, speed.world);
    speed.noise = c->noise_deg * sqrt(1.0 / newest.count + 1.0 / base.count) / dt_s;
    glm_vec3_normalize_to(base.world, speed.from);
    return speed;
}

/* The slope of gaze in the world over the last 100 ms, by least squares, and the standard deviation of its
 * noise. */
static double slope(const struct trk_classifier *c, double *out_noise)
{
    uint64_t now_ns = past(c, 0)->time_ns, count = 0;
    double t = 0, tt = 0;
    vec3 x = {0}, tx = {0};
    for (; count < kept(c); count++) {
        const struct trk_past *p = past(c, count);
        if (p->time_ns < c->since_ns || now_ns - p->time_ns > pursuit_ns) break;
        double age_s = (double)(now_ns - p->time_ns) * 1e-9;
        t += age_s;
        tt += age_s * age_s;
        glm_vec3_add(x, (float *)p->world, x);
        glm_vec3_muladds((float *)p->world, (float)age_s, tx);
    }
    double spread = tt - t * t / (double)count;
    *out_noise = INFINITY;
    if (count < 3 || spread <= 0) return 0;
    glm_vec3_muladds(x, (float)(-t / (double)count), tx);
    *out_noise = c->noise_deg / sqrt(spread);
    return glm_deg(glm_vec3_norm(tx)) / spread;
}

/* The second difference of three successive samples does not show smooth movement. Its variance is six times
 * that of one sample, and its length is Rayleigh distributed. The estimate steps towards the median of that
 * length, up as often as down, so a saccade hardly disturbs it (stochastic approximation: Robbins and Monro
 * 1951). */
static void measure_noise(struct trk_classifier *c)
{
    if (c->count < 3) return;
    const struct trk_past *a = past(c, 0), *b = past(c, 1), *d = past(c, 2);
    uint64_t newer_ns = a->time_ns - b->time_ns, older_ns = b->time_ns - d->time_ns;
    if (newer_ns > older_ns * 3 / 2 || older_ns > newer_ns * 3 / 2) return;
    vec3 second;
    glm_vec3_add((float *)a->world, (float *)d->world, second);
    glm_vec3_muladds((float *)b->world, -2, second);
    double median = sqrt(2 * M_LN2) * sqrt(6) * c->noise_deg;
    double step = fmax(least_noise_step, first_noise_step / (double)++c->noises_seen);
    c->noise_deg *= glm_deg(glm_vec3_norm(second)) > median ? 1 + step : 1 / (1 + step);
    c->noise_deg = fmax(c->noise_deg, least_noise_deg);
}

/* --- states --- */

static void enter(struct trk_classifier *c, enum trk_state state, uint64_t since_ns)
{
    c->state = state;
    c->since_ns = since_ns;
    c->steady_ns = past(c, 0)->time_ns;
}

/* End the saccade if the newest samples are at rest again, or if it has lasted too long. */
static void follow_saccade(struct trk_classifier *c, uint64_t now_ns)
{
    struct speed speed = speed_over(c, offset_span, 0);
    double threshold = fmax(offset_span.least_deg_s, offset_noises * speed.noise);
    if (speed.lesser >= threshold && now_ns - c->since_ns <= longest_saccade_ns) return;
    enter(c, TRK_FIXATION, past(c, 1)->time_ns);
}

/* Begin or end a pursuit when the slope has been on the other side of its threshold for long enough.
 * steady_ns is when it was last on the side of the present state. */
static void follow_slope(struct trk_classifier *c, uint64_t now_ns)
{
    double noise, speed = slope(c, &noise);
    double threshold = fmax(pursuit_deg_s, pursuit_noises * noise);
    bool pursues = c->state == TRK_PURSUIT;
    if (pursues ? speed >= 0.5 * threshold : speed < threshold)
        c->steady_ns = now_ns;
    else if (now_ns - c->steady_ns >= pursuit_ns)
        enter(c, pursues ? TRK_FIXATION : TRK_PURSUIT, now_ns - pursuit_ns);
}

/* Does this sample continue the last one? Not after a long gap, and not after a short one in which the eye
 * jumped. */
static bool goes_on(const struct trk_classifier *c, uint64_t time_ns, const float world[3])
{
    if (!c->count) return false;
    uint64_t gap_ns = time_ns - past(c, 0)->time_ns;
    if (c->count < 2 || gap_ns < short_gap_ns || gap_ns < 2 * c->interval_ns) return gap_ns < TRK_BRIDGED_NS;
    double jump_deg = fmax(TRK_LEAST_JUMP_DEG, onset_noises * c->noise_deg);
    return gap_ns < TRK_BRIDGED_NS && trk_angle_deg(past(c, 0)->world, world) < jump_deg;
}

enum trk_state trk_classify(struct trk_classifier *c, uint64_t time_ns, const float head[3],
                            const float world[3])
{
    bool bridged = goes_on(c, time_ns, world);
    if (bridged) {
        uint64_t interval_ns = time_ns - past(c, 0)->time_ns;
        c->interval_ns = c->count == 1 ? interval_ns : (15 * c->interval_ns + interval_ns) / 16;
    } else {
        c->count = 0;
    }
    struct trk_past *p = &c->past[c->count++ % TRK_PAST];
    p->time_ns = time_ns;
    memcpy(p->head, head, sizeof p->head);
    memcpy(p->world, world, sizeof p->world);
    if (!bridged) {
        enter(c, TRK_FIXATION, time_ns);
        return c->state;
    }

    double fastest = speed_over(c, peak_span, 0).world;
    if (c->state == TRK_SACCADE) {
        c->peak_deg_s = fmaxf(c->peak_deg_s, (float)fastest);
        follow_saccade(c, time_ns);
        return c->state;
    }
    const bool moves = c->state == TRK_PURSUIT || c->steady_ns < past(c, 1)->time_ns;
    for (int i = 0; i < ONSETS; i++) {
        struct speed speed = speed_over(c, onset_spans[i], c->since_ns);
        double least_deg_s = moves ? moving_onset_deg_s : onset_spans[i].least_deg_s;
        if (speed.lesser <= fmax(least_deg_s, onset_noises * speed.noise)) continue;
        /* The oldest base contains nothing of the saccade. */
        struct speed oldest = speed_over(c, onset_spans[ONSETS - 1], c->since_ns);
        memcpy(c->from, oldest.world > 0 ? oldest.from : speed.from, sizeof c->from);
        c->peak_deg_s = (float)fmax(fastest, speed.world);
        enter(c, TRK_SACCADE, time_ns);
        return c->state;
    }
    measure_noise(c);
    follow_slope(c, time_ns);
    return c->state;
}

const char *trk_state_name(enum trk_state state)
{
    static const char *const names[] = {"fixation", "pursuit",  "saccade", "blink",
                                        "lost",     "fallback", "frozen"};
    return names[state];
}
