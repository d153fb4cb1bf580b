/* Feeds an attention sample by sample, for tests, and checks its aims. */
#ifndef FOVEAD_TESTS_TRACKER_ATTENTION_H
#define FOVEAD_TESTS_TRACKER_ATTENTION_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "arc.h"
#include "events.h"

#include <math.h>
#include <string.h>

#define MS UINT64_C(1000000)

static inline void at(double azimuth_deg, double elevation_deg, float out[3])
{
    double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
    out[0] = (float)(sin(a) * cos(e));
    out[1] = (float)sin(e);
    out[2] = (float)(-cos(a) * cos(e));
}

static struct trk_attention *attention;
static struct trk_aim gaze;
static uint64_t tick; /* samples so far, at 120 Hz */

static inline void begin(const struct trk_attention_options *options)
{
    trk_attention_destroy(attention);
    attention = trk_attention_create(options);
    assert_non_null(attention);
    tick = 0;
}

static inline int enter(void **state)
{
    (void)state;
    begin(&(struct trk_attention_options){0});
    return 0;
}

static inline int leave(void **state)
{
    (void)state;
    trk_attention_destroy(attention);
    attention = NULL;
    return 0;
}

static inline uint64_t now_ns(void)
{
    return tick * 1000000000 / 120;
}

static inline struct trk_sample sample_of(uint32_t valid, double azimuth_deg)
{
    struct trk_sample s = {.sequence = ++tick, .valid = valid};
    s.device_ns = now_ns();
    s.arrival_ns = 5000 * MS + now_ns();
    at(azimuth_deg, 0, s.direction);
    at(azimuth_deg, 0, s.eye[0].direction);
    at(azimuth_deg, 0, s.eye[1].direction);
    s.eye[0].openness = s.eye[1].openness = valid & TRK_DIRECTION ? 1 : 0.1f;
    return s;
}

static inline void turn_head(struct trk_sample *sample, double azimuth_deg)
{
    versor head; /* aligned as cglm needs it */
    glm_quatv(head, (float)(-azimuth_deg * M_PI / 180), GLM_YUP);
    memcpy(&sample->head[3], head, sizeof head);
}

static inline void take(const struct trk_sample *sample)
{
    trk_attend(attention, sample, sample->arrival_ns, &gaze);
}

/* Take n samples at this azimuth. */
static inline void look(int n, double azimuth_deg)
{
    for (int i = 0; i < n; i++) {
        struct trk_sample s = sample_of(TRK_DIRECTION, azimuth_deg);
        take(&s);
    }
}

static inline void hide(int n, uint32_t valid)
{
    for (int i = 0; i < n; i++) {
        struct trk_sample s = sample_of(valid, 0);
        take(&s);
    }
}

static inline void aims_at(double azimuth_deg, double tolerance_deg)
{
    float direction[3];
    at(azimuth_deg, 0, direction);
    if (!(trk_angle_deg(direction, gaze.direction) <= tolerance_deg))
        fail_msg("%.2f degrees from %.2f (%s: %s)", trk_angle_deg(direction, gaze.direction), azimuth_deg,
                 trk_state_name(gaze.state), gaze.why);
}

static inline void is(enum trk_state state, const char *source)
{
    if (gaze.state != state || strcmp(gaze.source, source) != 0)
        fail_msg("%s from %s (%s), expected %s from %s", trk_state_name(gaze.state), gaze.source, gaze.why,
                 trk_state_name(state), source);
}

#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)

#endif
