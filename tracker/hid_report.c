/* Reports of an eye tracker on HID: from bits to numbers, and from numbers to a sample. */
#include "hid_report.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* Eyes that are nearer to the screen or farther from it cannot be looking at it. */
static const double nearest_m = 0.05, farthest_m = 5;

/* A gaze point that is off the screen by more than this many screens is invalid. */
static const double farthest_share = 10;

static uint64_t take_bits(const uint8_t *bytes, size_t first, unsigned count)
{
    uint64_t value = 0;
    for (unsigned got = 0; got < count;) {
        size_t at = first + got;
        unsigned skip = at % 8, part = 8 - skip < count - got ? 8 - skip : count - got;
        value |= (uint64_t)(bytes[at / 8] >> skip & ((1u << part) - 1)) << got;
        got += part;
    }
    return value;
}

static int64_t extend(uint64_t value, unsigned bits)
{
    uint64_t sign = UINT64_C(1) << (bits - 1);
    return (int64_t)((value ^ sign) - sign);
}

static void take_field(const struct trk_hid_field *field, const uint8_t *payload,
                       struct trk_hid_values *out_values)
{
    uint64_t bits = take_bits(payload, field->first_bit, field->bits);
    uint32_t bit = UINT32_C(1) << field->quantity;
    if (field->quantity == TRK_HID_TIMESTAMP) {
        out_values->ticks = bits;
        out_values->has |= bit;
        return;
    }
    int64_t raw = field->is_signed ? extend(bits, field->bits) : (int64_t)bits;
    if (!field->is_signed && bits > INT64_MAX) raw = INT64_MAX;
    if (field->has_range && (raw < field->low || raw > field->high)) return;
    out_values->value[field->quantity] = field->offset + field->scale * (double)raw;
    out_values->has |= bit;
    if (field->quantity == TRK_HID_GAZE_X) out_values->is_share = field->is_share;
}

bool trk_hid_decode(const struct trk_hid_layout *layout, enum trk_hid_type type, const uint8_t *bytes,
                    size_t size, struct trk_hid_values *out_values)
{
    memset(out_values, 0, sizeof *out_values);
    if (layout->numbered && size < 1) return false;
    uint8_t report = layout->numbered ? bytes[0] : 0;
    size_t id = layout->numbered;
    if (layout->bits[type][report] == 0 || (size - id) * 8 < layout->bits[type][report]) return false;
    for (size_t i = 0; i < layout->fields; i++)
        if (layout->field[i].type == type && layout->field[i].report == report)
            take_field(&layout->field[i], bytes + id, out_values);
    return true;
}

bool trk_hid_encode(const struct trk_hid_field *field, uint64_t value, uint8_t *bytes, size_t size)
{
    if (value > INT64_MAX || field->first_bit + (size_t)field->bits > 8 * (size - 1)) return false;
    if (field->has_range && ((int64_t)value < field->low || (int64_t)value > field->high)) return false;
    bytes[0] = field->report;
    for (unsigned i = 0; i < field->bits; i++) {
        size_t at = 8 + field->first_bit + i;
        if (value >> i & 1) bytes[at / 8] |= (uint8_t)(1u << at % 8);
    }
    return true;
}

/* --- to our frame --- */

static bool has(const struct trk_hid_values *values, enum trk_hid_quantity first, unsigned count)
{
    uint32_t bits = ((UINT32_C(1) << count) - 1) << first;
    return (values->has & bits) == bits;
}

/* Convert a point (X, Y, Z) from the device's frame to ours: Y is reversed, and the origin moves from the
 * screen's corner to the place in front of its middle. */
static void point(const double value[3], const struct trk_screen *screen, vec3 out)
{
    out[0] = (float)(value[0] - screen->width_m / 2);
    out[1] = (float)(screen->height_m / 2 - value[1]);
    out[2] = (float)(value[2] - screen->distance_m);
}

static bool is_near(const double value[3])
{
    return fabs(value[0]) <= farthest_m && fabs(value[1]) <= farthest_m && fabs(value[2]) <= farthest_m;
}

/* The position of an eye in front of the screen. Sample drivers send zeros for an unknown position. */
static bool eye_point(const struct trk_hid_values *values, enum trk_hid_quantity x,
                      const struct trk_screen *screen, vec3 out)
{
    const double *value = &values->value[x];
    if (!has(values, x, 3) || !is_near(value) || value[2] < nearest_m) return false;
    point(value, screen, out);
    return true;
}

static bool aim(const vec3 from, const vec3 to, float out_direction[3])
{
    vec3 direction;
    glm_vec3_sub((float *)to, (float *)from, direction);
    float length = glm_vec3_norm(direction);
    if (!isfinite(length) || length < 1e-6f) return false;
    glm_vec3_scale(direction, 1 / length, out_direction);
    return true;
}

/* Reversing Y also reverses rotations about X and Z. No document states the order of rotations; yaw, then
 * pitch, then roll is usual for heads. */
static bool head_pose(const struct trk_hid_values *values, const struct trk_screen *screen,
                      struct trk_sample *sample)
{
    if (!has(values, TRK_HID_HEAD_X, 3) || !has(values, TRK_HID_TURN_X, 3)) return false;
    if (!is_near(&values->value[TRK_HID_HEAD_X])) return false;
    const double *turn = &values->value[TRK_HID_TURN_X];
    versor yaw, pitch, roll, head;
    vec3 position;
    point(&values->value[TRK_HID_HEAD_X], screen, position);
    glm_quatv(yaw, (float)turn[1], (vec3){0, 1, 0});
    glm_quatv(pitch, (float)-turn[0], (vec3){1, 0, 0});
    glm_quatv(roll, (float)-turn[2], (vec3){0, 0, 1});
    glm_quat_mul(yaw, pitch, head);
    glm_quat_mul(head, roll, head);
    memcpy(sample->head, position, 3 * sizeof(float));
    memcpy(sample->head + 3, head, 4 * sizeof(float));
    return true;
}

/* Convert a point or a direction from the world, where it was computed, to the head frame of a sample. */
static void into_head(const struct trk_sample *sample, bool is_point, float v[3])
{
    versor head;
    vec3 copy;
    memcpy(copy, v, sizeof copy);
    memcpy(head, sample->head + 3, sizeof head);
    if (is_point) glm_vec3_sub(copy, (float *)sample->head, copy);
    glm_quat_inv(head, head);
    glm_quat_rotatev(head, copy, copy);
    memcpy(v, copy, sizeof copy);
}

void trk_hid_sample(const struct trk_hid_values *values, const struct trk_screen *screen,
                    struct trk_sample *out_sample)
{
    struct trk_sample *sample = out_sample;
    vec3 target = {0, 0, -screen->distance_m}, eye[2], origin = {0, 0, 0};
    double x = values->value[TRK_HID_GAZE_X] / (values->is_share ? 1 : screen->width_m);
    double y = values->value[TRK_HID_GAZE_Y] / (values->is_share ? 1 : screen->height_m);
    bool gaze = has(values, TRK_HID_GAZE_X, 2) && fabs(x) <= farthest_share && fabs(y) <= farthest_share;
    sample->valid = 0;
    if (gaze) {
        sample->screen[0] = (float)x;
        sample->screen[1] = (float)y;
        target[0] = (sample->screen[0] - 0.5f) * screen->width_m;
        target[1] = (0.5f - sample->screen[1]) * screen->height_m;
        sample->valid |= TRK_SCREEN;
    }
    int eyes = 0;
    for (int i = 0; i < 2; i++) {
        if (!eye_point(values, i ? TRK_HID_RIGHT_X : TRK_HID_LEFT_X, screen, eye[i])) continue;
        glm_vec3_add(origin, eye[i], origin);
        memcpy(sample->eye[i].origin, eye[i], sizeof sample->eye[i].origin);
        sample->valid |= (uint32_t)TRK_LEFT_ORIGIN << 4 * i;
        if (gaze && aim(eye[i], target, sample->eye[i].direction))
            sample->valid |= (uint32_t)TRK_LEFT_DIRECTION << 4 * i;
        eyes++;
    }
    if (eyes) {
        glm_vec3_scale(origin, 1 / (float)eyes, sample->origin);
        sample->valid |= TRK_ORIGIN;
    }
    if (gaze && aim(eyes ? sample->origin : origin, target, sample->direction))
        sample->valid |= TRK_DIRECTION;
    if (!head_pose(values, screen, sample)) return;
    sample->valid |= TRK_HEAD;
    if (sample->valid & TRK_DIRECTION) into_head(sample, false, sample->direction);
    if (sample->valid & TRK_ORIGIN) into_head(sample, true, sample->origin);
    for (int i = 0; i < 2; i++) {
        if (sample->valid & TRK_LEFT_DIRECTION << 4 * i) into_head(sample, false, sample->eye[i].direction);
        if (sample->valid & TRK_LEFT_ORIGIN << 4 * i) into_head(sample, true, sample->eye[i].origin);
    }
}
