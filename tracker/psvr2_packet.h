/* psvr2_packet: the gaze packets of headsets with a vendor's own USB interface. A layout says at which offset
 * each field of a packet lies.
 *
 * So far there is one layout, that of the PlayStation VR2. A device whose packets hold the same fields at
 * other offsets needs only another layout. The public sources of Monado's psvr2 driver and of PSVR2Toolkit
 * agree on every offset used here. */
#ifndef FOVEAD_TRACKER_PSVR2_PACKET_H
#define FOVEAD_TRACKER_PSVR2_PACKET_H

#include "tracker.h"

/* Offsets in bytes. A flag is a little-endian u32, not 0 if what follows it holds; vectors are three floats,
 * origins in mm. */
struct trk_packet_layout {
    char magic[4]; /* what the packet begins with, magic_size of them */
    size_t magic_size, smallest;
    size_t clock;         /* u32 that wraps */
    double clock_tick_ns; /* its unit */
    size_t eye[2];        /* left, right; the following are relative to these */
    size_t origin_valid, origin, direction_valid, direction, pupil_valid, pupil_mm, blink_valid, blink;
    size_t combined_origin_valid, combined_origin, combined_direction_valid, combined_direction;
    float axes[3]; /* by which x, y and z are multiplied to be in our frame */
};

extern const struct trk_packet_layout trk_psvr2_layout;

/* Decode a packet of size bytes. Fills valid, directions, origins, openness and pupils of *out_sample, each
 * under its own flag and only if it is finite and possible, and the device's clock. False if it is no such
 * packet or too short; longer ones are of newer firmware. */
bool trk_packet_parse(const struct trk_packet_layout *layout, const uint8_t *bytes, size_t size,
                      struct trk_sample *out_sample, uint32_t *out_clock);

#endif
