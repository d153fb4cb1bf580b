/* Numbers and directions as people write them. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cglm/cglm.h>

#include "numbers.h"

uint64_t dmn_now_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

bool dmn_parse_numbers(const char *text, int count, double *out_numbers)
{
    for (int i = 0; i < count; i++) {
        char *end;

        out_numbers[i] = strtod(text, &end);
        if (end == text || !isfinite(out_numbers[i]) || *end != (i + 1 < count ? ',' : '\0')) return false;
        text = end + 1;
    }
    return true;
}

/* Digits alone: strtoull would take signs and spaces. */
static const char *digits(const char *text, uint64_t *out_number)
{
    char *end;

    if (*text < '0' || *text > '9') return NULL;
    errno = 0;
    *out_number = strtoull(text, &end, 10);
    return errno ? NULL : end;
}

bool dmn_parse_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out_number)
{
    const char *end = digits(text, out_number);

    return end && !*end && *out_number >= low && *out_number <= high;
}

bool dmn_parse_size(const char *text, int *out_width, int *out_height)
{
    uint64_t width, height = 0;
    const char *end = digits(text, &width);

    if (!end) return false;
    if (*end == 'x' && (!(end = digits(end + 1, &height)) || !height)) return false;
    if (*end || !width || width > 65536 || height > 65536) return false;
    *out_width = (int)width;
    *out_height = (int)height;
    return true;
}

bool dmn_camera_is_in_range(const double camera[3])
{
    for (int i = 0; i < 3; i++)
        if (!(fabs(camera[i]) <= DMN_FARTHEST)) return false;
    return true;
}

void dmn_angles(const float direction[3], double *out_yaw_deg, double *out_pitch_deg)
{
    *out_yaw_deg = atan2(direction[0], -direction[2]) * 180 / M_PI;
    *out_pitch_deg = asin(fmax(-1, fmin(1, direction[1]))) * 180 / M_PI;
}

void dmn_orientation(const float direction[3], float out_orientation[4])
{
    versor turn, tilt, both;
    double yaw, pitch;

    dmn_angles(direction, &yaw, &pitch);
    glm_quatv(turn, glm_rad(-(float)yaw), (vec3){0, 1, 0});
    glm_quatv(tilt, glm_rad((float)pitch), (vec3){1, 0, 0});
    glm_quat_mul(turn, tilt, both);
    memcpy(out_orientation, both, sizeof(float[4]));
}
