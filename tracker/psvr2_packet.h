/* psvr2_packet: the gaze packets of headsets with a vendor's own USB interface. A layout says at which offset
 * each field of a packet is.
 *
 * So far there is one layout, that of the PlayStation VR2. A device whose packets hold the same fields at
 * other offsets only needs another layout. The public sources of Monado's psvr2 driver and of PSVR2Toolkit
 * agree on every offset used here. */
#ifndef FOVEAD_TRACKER_PSVR2_PACKET_H
#define FOVEAD_TRACKER_PSVR2_PACKET_H

#include "tracker.h"

/* Offsets in bytes. A flag is a little-endian u32 that is not 0 if the field after it is valid. Vectors are
 * three floats; origins are in mm. */
struct trk_packet_layout {
    char magic[4]; /* packets begin with magic_size bytes of magic */
    size_t magic_size, smallest;
    size_t clock;         /* u32 that wraps */
    double clock_tick_ns; /* length of a tick */
    size_t eye[2];        /* left, right; the offsets in the next line are relative to these */
    size_t origin_valid, origin, direction_valid, direction, pupil_valid, pupil_mm, blink_valid, blink;
    size_t combined_origin_valid, combined_origin, combined_direction_valid, combined_direction;
    float axes[3]; /* factors that take x, y and z to our frame */
};

extern const struct trk_packet_layout trk_psvr2_layout;

/* Decode a packet of size bytes into valid, directions, origins, openness and pupils of *out_sample, and the
 * device's clock. A field is valid only if its own flag is set and its value is finite and possible. Returns
 * false if the bytes are not such a packet or too short. Longer packets come from newer firmware. */
bool trk_packet_parse(const struct trk_packet_layout *layout, const uint8_t *bytes, size_t size,
                      struct trk_sample *out_sample, uint32_t *out_clock);

#endif
