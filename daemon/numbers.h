/* numbers: numbers and directions as people write them; and the time. */
#ifndef FOVEAD_DAEMON_NUMBERS_H
#define FOVEAD_DAEMON_NUMBERS_H

#include <stdbool.h>
#include <stdint.h>

/* CLOCK_MONOTONIC. */
uint64_t dmn_now_ns(void);

/* Exactly count finite numbers with commas between them and nothing else. */
bool dmn_parse_numbers(const char *text, int count, double *out_numbers);
/* A whole number from low to high. */
bool dmn_parse_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out_number);
/* "WxH"; *out_height is 0 if only "W" was given. Both from 1 to 65536. */
bool dmn_parse_size(const char *text, int *out_width, int *out_height);

/* The largest distance of the camera from the origin along each axis, m: beyond it, floats are metres apart.
 */
enum { DMN_FARTHEST = 10000000 };

/* Can the camera be there? */
bool dmn_camera_is_in_range(const double camera[3]);

/* Azimuth (right of -Z) and elevation, deg. */
void dmn_angles(const float direction[3], double *out_yaw_deg, double *out_pitch_deg);
/* Orientation (x y z w, view to world) of a view whose middle is direction and that is not rolled. */
void dmn_orientation(const float direction[3], float out_orientation[4]);

#endif
