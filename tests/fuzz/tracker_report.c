/* Fuzzing of what eye trackers send: HID reports under a layout, packets of vendor USB, and the time stamps
 * in both. Decoded samples must be finite, in range and of unit length, and mapped times must not go back.
 *
 * The first byte chooses between a descriptor of the tests, a descriptor in the input, and a packet. See
 * fuzz.h. */
#include "fuzz.h"

#include "clock.h"
#include "hid_report.h"
#include "psvr2_packet.h"

#include "../device/descriptors.h"

#include <math.h>

enum { PACKET = 328 };

static void check_unit(const float *v)
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(fabsf(length - 1) < 1e-3f)) abort();
}

static void check_sample(const struct trk_sample *sample)
{
    if (sample->valid & TRK_DIRECTION) check_unit(sample->direction);
    for (int i = 0; i < 2; i++)
        if (sample->valid & TRK_LEFT_DIRECTION << 4 * i) check_unit(sample->eye[i].direction);
    for (int i = 0; i < 3; i++) {
        if ((sample->valid & TRK_ORIGIN) && !isfinite(sample->origin[i])) abort();
        if ((sample->valid & TRK_LEFT_ORIGIN) && !isfinite(sample->eye[0].origin[i])) abort();
    }
}

/* Map the next stamp, which arrives a millisecond after the last one. Mapped times neither go back nor exceed
 * the arrival. */
static void check_clock(struct trk_clock *clock, uint64_t ticks)
{
    uint64_t device_ns, sensor_ns, before_ns = (uint64_t)clock->device_ns, seen_ns = clock->sensor_ns;
    uint64_t arrival_ns = clock->arrival_ns + 1000000;
    trk_clock_add(clock, ticks, arrival_ns, &device_ns, &sensor_ns);
    if (device_ns < before_ns || sensor_ns < seen_ns || sensor_ns > arrival_ns) abort();
}

static void hid_report(const struct trk_hid_layout *layout, const uint8_t *data, size_t size)
{
    static const struct trk_screen screen = {0.5f, 0.3f, 0.65f};
    const struct trk_hid_field *stamp = trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP);
    struct trk_clock clock;
    struct trk_hid_values values;
    if (stamp) trk_clock_init(&clock, trk_hid_clock_bits(stamp), stamp->scale * 1e9);
    for (size_t step = 0; step < size && step < 64; step += 16) {
        struct trk_sample sample = {0};
        if (!trk_hid_decode(layout, TRK_HID_INPUT, data + step, size - step, &values)) continue;
        for (int q = 0; q < TRK_HID_QUANTITIES; q++)
            if ((values.has >> q & 1) && !isfinite(values.value[q])) abort();
        trk_hid_sample(&values, &screen, &sample);
        check_sample(&sample);
        if (stamp) check_clock(&clock, values.ticks);
    }
}

static void packet(const uint8_t *data, size_t size)
{
    struct trk_clock clock;
    trk_clock_init(&clock, 32, 1000);
    for (size_t at = 0; at < size; at += PACKET) {
        struct trk_sample sample = {0};
        uint32_t ticks;
        if (!trk_packet_parse(&trk_psvr2_layout, data + at, size - at, &sample, &ticks)) return;
        check_sample(&sample);
        check_clock(&clock, ticks);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct trk_hid_layout layout;
    char error[TRK_ERROR_SIZE];
    if (size < 2) return 0;
    switch (data[0] & 3) {
    case 0:
        packet(data + 1, size - 1);
        return 0;
    case 1:
        if (!trk_hid_parse(reference_descriptor, sizeof reference_descriptor, &layout, error)) abort();
        hid_report(&layout, data + 1, size - 1);
        return 0;
    case 2:
        if (!trk_hid_parse(short_descriptor, sizeof short_descriptor, &layout, error)) abort();
        hid_report(&layout, data + 1, size - 1);
        return 0;
    default: {
        size_t length = data[1] < size - 2 ? data[1] : size - 2;
        if (trk_hid_parse(data + 2, length, &layout, error))
            hid_report(&layout, data + 2 + length, size - 2 - length);
        return 0;
    }
    }
}

#ifndef LIBFUZZER
int main(void)
{
    return fuzz_run_corpus(CORPUS, 200000);
}
#endif
