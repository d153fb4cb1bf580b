/* protocol/internal.h: what the files of this folder share, for no other folder. */
#ifndef FOVEAD_PROTOCOL_INTERNAL_H
#define FOVEAD_PROTOCOL_INTERNAL_H

#include "protocol.h"

#pragma GCC visibility push(hidden)

/* --- text --- */

/* Write one line into out_error, and return false. Control characters, which a peer's text may have, become
 * '?'. */
bool pro_fail(char out_error[PRO_ERROR_SIZE], const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Replace the control characters (C0, DEL, C1) of a peer's text, which could otherwise drive a terminal.
 * Writes only where there is one, so protobuf-c's constant empty string is safe. */
void pro_clean(char *text);

/* --- sockets --- */

#define PRO_NEVER UINT64_MAX /* a deadline that does not come */

uint64_t pro_now_ns(void);                /* CLOCK_MONOTONIC */
uint64_t pro_deadline_ns(int timeout_ms); /* negative: PRO_NEVER */

/* Wait for poll events on fd until the deadline; if it has passed, check once. Returns the events, or 0 at
 * the deadline. */
short pro_wait(int fd, short events, uint64_t deadline_ns);

/* --- frames --- */

/* Does the reader hold a whole frame, so that pro_reader_take() will not return PRO_MORE? */
bool pro_reader_ready(const struct pro_reader *reader);

/* --- clock --- */

/* The daemon's clock relative to ours, from Pings and Pongs. The smallest round trip is the most exact, but
 * the clocks of two machines drift apart by tens of parts per million, so an estimate counts less as it ages.
 */
struct pro_estimate {
    bool known;
    uint64_t round_trip_ns;
    int64_t offset_ns;    /* daemon's clock minus ours */
    uint64_t measured_ns; /* our clock */
};
void pro_estimate_add(struct pro_estimate *estimate, uint64_t sent_ns, uint64_t daemon_ns,
                      uint64_t received_ns);

/* --- picture --- */

/* An empty picture of the film that Welcome describes; NULL and a line in out_error if the sizes make no
 * sense or go beyond the limits in protocol.h. The caller frees with pro_picture_destroy(). */
struct pro_picture *pro_picture_create(const Fovea__Welcome *welcome, char out_error[PRO_ERROR_SIZE]);
void pro_picture_destroy(struct pro_picture *picture); /* accepts NULL */

/* Is there such a tile? */
bool pro_picture_has_place(const struct pro_picture *picture, uint32_t level, uint32_t x, uint32_t y);

/* Keep a tile of tile_size x tile_size x RGB floats, finite, at a place that exists. A newer generation
 * empties the picture first; a tile of an older one is dropped. False only when memory is short. */
bool pro_picture_put(struct pro_picture *picture, uint64_t generation, uint32_t level, uint32_t x, uint32_t y,
                     const float *rgb);

#pragma GCC visibility pop

#endif
