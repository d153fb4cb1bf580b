/* Gaze packets of vendor USB devices: the layout, and the conversion to our frame. */
#include "psvr2_packet.h"

#include <math.h>
#include <string.h>

/* Packets have 328 bytes; the last four, a convergence distance, came with newer firmware. The headset's
 * frame is ours turned by 180 degrees about Y. */
const struct trk_packet_layout trk_psvr2_layout = {
    .magic = "GS",
    .magic_size = 2,
    .smallest = 324,
    .clock = 0x050, /* low half of 64 bits; some firmware may leave the high half empty */
    .clock_tick_ns = 1000,
    .eye = {0x05c, 0x0a4},
    .origin_valid = 0x00,
    .origin = 0x04,
    .direction_valid = 0x10,
    .direction = 0x14,
    .pupil_valid = 0x20,
    .pupil_mm = 0x24,
    .blink_valid = 0x40,
    .blink = 0x44,
    .combined_origin_valid = 0x0ec,
    .combined_origin = 0x0f0,
    .combined_direction_valid = 0x0fc,
    .combined_direction = 0x100,
    .axes = {-1, 1, -1},
};

/* An eye that is farther from the middle of the headset, or a pupil that is wider, is invalid. */
static const float farthest_m = 0.5f, widest_mm = 15;

/* A direction whose length differs from 1 by more than this is invalid. */
static const float slack = 0.1f;

static uint32_t take_u32(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static float take_float(const uint8_t *bytes)
{
    uint32_t bits = take_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Read a vector and convert it to our frame. Returns its length. */
static float take_vector(const struct trk_packet_layout *layout, const uint8_t *bytes, float unit,
                         float out[3])
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = take_float(bytes + 4 * i) * unit * layout->axes[i];
        sum += (double)out[i] * out[i];
    }
    return (float)sqrt(sum);
}

static bool take_origin(const struct trk_packet_layout *layout, const uint8_t *flag, const uint8_t *bytes,
                        float out[3])
{
    return take_u32(flag) && take_vector(layout, bytes, 0.001f, out) <= farthest_m;
}

static bool take_direction(const struct trk_packet_layout *layout, const uint8_t *flag, const uint8_t *bytes,
                           float out[3])
{
    if (!take_u32(flag)) return false;
    float length = take_vector(layout, bytes, 1, out);
    if (!(fabsf(length - 1) <= slack)) return false;
    for (int i = 0; i < 3; i++) out[i] /= length;
    return true;
}

static uint32_t take_eye(const struct trk_packet_layout *layout, const uint8_t *eye, struct trk_eye *out)
{
    uint32_t valid = 0;
    if (take_direction(layout, eye + layout->direction_valid, eye + layout->direction, out->direction))
        valid |= TRK_LEFT_DIRECTION;
    if (take_origin(layout, eye + layout->origin_valid, eye + layout->origin, out->origin))
        valid |= TRK_LEFT_ORIGIN;
    out->pupil_mm = take_float(eye + layout->pupil_mm);
    if (take_u32(eye + layout->pupil_valid) && out->pupil_mm > 0 && out->pupil_mm <= widest_mm)
        valid |= TRK_LEFT_PUPIL;
    out->openness = take_u32(eye + layout->blink) ? 0 : 1;
    if (take_u32(eye + layout->blink_valid)) valid |= TRK_LEFT_OPENNESS;
    return valid;
}

bool trk_packet_parse(const struct trk_packet_layout *layout, const uint8_t *bytes, size_t size,
                      struct trk_sample *out_sample, uint32_t *out_clock)
{
    if (size < layout->smallest || memcmp(bytes, layout->magic, layout->magic_size) != 0) return false;
    out_sample->valid = 0;
    if (take_direction(layout, bytes + layout->combined_direction_valid, bytes + layout->combined_direction,
                       out_sample->direction))
        out_sample->valid |= TRK_DIRECTION;
    if (take_origin(layout, bytes + layout->combined_origin_valid, bytes + layout->combined_origin,
                    out_sample->origin))
        out_sample->valid |= TRK_ORIGIN;
    for (int i = 0; i < 2; i++)
        out_sample->valid |= take_eye(layout, bytes + layout->eye[i], &out_sample->eye[i]) << 4 * i;
    *out_clock = take_u32(bytes + layout->clock);
    return true;
}
