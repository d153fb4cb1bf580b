/* The equirectangular map and frames on the sphere: written once, used everywhere in this folder. */
#ifndef FOVEAD_RENDERER_SPHERE_H
#define FOVEAD_RENDERER_SPHERE_H

#include <math.h>

#include <cglm/struct.h>

static inline vec3s rnd_vec(const float v[3])
{
    return (vec3s){{v[0], v[1], v[2]}};
}

/* Direction at image coordinates u (wraps, 0.5 is forward) and v (0 is up), both in [0,1]. */
static inline vec3s rnd_from_uv(float u, float v)
{
    const float azimuth = (u - 0.5f) * 2.0f * (float)M_PI, elevation = (0.5f - v) * (float)M_PI;
    const float c = cosf(elevation);
    return (vec3s){{c * sinf(azimuth), sinf(elevation), -c * cosf(azimuth)}};
}

/* Image coordinates of a unit direction: u in [0,1), v in [0,1]. */
static inline void rnd_to_uv(vec3s d, float *out_u, float *out_v)
{
    const float u = 0.5f + atan2f(d.x, -d.z) * (float)(0.5 / M_PI);
    *out_u = u >= 1.0f ? 0.0f : u;
    *out_v = 0.5f - asinf(fmaxf(-1.0f, fminf(1.0f, d.y))) * (float)(1.0 / M_PI);
}

/* Solid angle of a texel of a row of an equirectangular image, but for a factor that all rows have in common.
 */
static inline float rnd_row_weight(int row, int height)
{
    return sinf(((float)row + 0.5f) * (float)M_PI / (float)height);
}

/* Angle between unit vectors, rad: exact for small angles too, where acos is not. */
static inline float rnd_angle(vec3s a, vec3s b)
{
    return 2.0f * atan2f(glms_vec3_norm(glms_vec3_sub(a, b)), glms_vec3_norm(glms_vec3_add(a, b)));
}

static inline float rnd_luminance(const float rgb[3])
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

#endif
