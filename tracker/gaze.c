/* The gaze of one sample: which eyes are trusted, and where they look together. */
#include "gaze.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* A lid that is less open than this is down. */
static const float half_open = 0.5f;

/* Is the lid of this eye (0 left, 1 right) known to be down? */
static bool is_lid_down(const struct trk_sample *sample, int eye)
{
    return (sample->valid & TRK_LEFT_OPENNESS << 4 * eye) && sample->eye[eye].openness < half_open;
}

bool trk_combine(struct trk_sample *sample)
{
    vec3 direction = {0}, origin = {0};
    int eyes = 0, origins = 0;
    bool is_mean = false;
    for (int i = 0; i < 2; i++) {
        /* an eye under its lid does not count if the other one is open */
        const bool other = (sample->valid & TRK_LEFT_DIRECTION << 4 * !i) && !is_lid_down(sample, !i);
        if ((sample->valid & TRK_LEFT_DIRECTION << 4 * i) && !(is_lid_down(sample, i) && other)) {
            glm_vec3_add(direction, sample->eye[i].direction, direction);
            eyes++;
        }
        if (sample->valid & TRK_LEFT_ORIGIN << 4 * i) {
            glm_vec3_add(origin, sample->eye[i].origin, origin);
            origins++;
        }
    }
    /* Two eyes that look in opposite directions have no mean. */
    if (!(sample->valid & TRK_DIRECTION) && glm_vec3_norm(direction) > 1e-3f) {
        glm_vec3_normalize_to(direction, sample->direction);
        sample->valid |= TRK_DIRECTION;
        is_mean = eyes == 2;
    }
    if (!(sample->valid & TRK_ORIGIN) && origins > 0) {
        glm_vec3_scale(origin, 1.f / (float)origins, sample->origin);
        sample->valid |= TRK_ORIGIN;
    }
    return is_mean;
}

bool trk_gaze_direction(const struct trk_sample *sample, float out_head[3], const char **out_source)
{
    const bool left = (sample->valid & TRK_LEFT_DIRECTION) && !is_lid_down(sample, 0);
    const bool right = (sample->valid & TRK_RIGHT_DIRECTION) && !is_lid_down(sample, 1);
    const char *source = "both eyes";
    vec3 direction = {0};
    bool known;
    if (trk_lids_closed(sample, &known)) return false;
    if (sample->valid & TRK_DIRECTION) {
        memcpy(direction, sample->direction, sizeof direction);
    } else {
        if (left) glm_vec3_add(direction, (float *)sample->eye[0].direction, direction);
        if (right) glm_vec3_add(direction, (float *)sample->eye[1].direction, direction);
        if (left != right) source = left ? "left eye" : "right eye";
    }
    float length = glm_vec3_norm(direction);
    if (!(length > 0.5f && length < 3)) return false; /* none, opposite eyes, or not numbers */
    glm_vec3_normalize_to(direction, out_head);
    if (out_source) *out_source = source;
    return true;
}

void trk_to_world(const struct trk_sample *sample, const float head[3], float out_world[3])
{
    vec3 direction = {head[0], head[1], head[2]};
    if (sample->valid & TRK_HEAD) {
        versor pose; /* a copy, because cglm needs it aligned */
        memcpy(pose, &sample->head[3], sizeof pose);
        if (fabsf(glm_quat_norm(pose) - 1) <= 1e-2f) glm_quat_rotatev(pose, direction, direction);
        glm_vec3_normalize(direction);
    }
    memcpy(out_world, direction, sizeof direction);
}

bool trk_lids_closed(const struct trk_sample *sample, bool *out_known)
{
    bool closed = true;
    *out_known = sample->valid & (TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS);
    for (int eye = 0; eye < 2; eye++)
        if (sample->valid & (TRK_LEFT_OPENNESS | TRK_LEFT_DIRECTION) << 4 * eye)
            closed &= is_lid_down(sample, eye);
    return *out_known && closed;
}

void trk_drop_head(struct trk_sample *sample)
{
    if (!(sample->valid & TRK_HEAD)) return;
    if (sample->valid & TRK_DIRECTION) trk_to_world(sample, sample->direction, sample->direction);
    for (int eye = 0; eye < 2; eye++)
        if (sample->valid & TRK_LEFT_DIRECTION << 4 * eye)
            trk_to_world(sample, sample->eye[eye].direction, sample->eye[eye].direction);
    sample->valid &= ~(uint32_t)(TRK_HEAD | TRK_ORIGIN | TRK_LEFT_ORIGIN | TRK_RIGHT_ORIGIN);
}

bool trk_world_direction(const struct trk_sample *sample, float out_world[3])
{
    float head[3];
    if (!trk_gaze_direction(sample, head, NULL)) return false;
    trk_to_world(sample, head, out_world);
    return true;
}
