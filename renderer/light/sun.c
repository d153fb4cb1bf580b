/* The sun. */
#include "light/sun.h"
#include "light/drop.h"

void rnd_sun_init(struct rnd_sun *sun, const float options[4])
{
    float towards[3];
    rnd_direction(glm_rad(options[0]), glm_rad(options[1]), towards);
    sun->direction = rnd_v3(towards[0], towards[1], towards[2]);
    /* A disc narrower than the steps between float directions is a point. */
    const double radius = (double)options[3] * 0.5 * M_PI / 180.0, sine = sin(radius);
    const bool disc = radius > 1e-6;
    sun->drop = disc ? rnd_drop_of(radius) : 0.0f;
    const float value = disc ? (float)((double)options[2] / (M_PI * sine * sine)) : options[2];
    sun->radiance = rnd_v3(value, value, value);
}

bool rnd_sun_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                   const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_sun *sun = scene->lights.sun;
    (void)choice, (void)point;
    out->distance = INFINITY;
    out->radiance = sun->radiance;
    out->delta = !(sun->drop > 0.0f);
    out->direction = sun->direction;
    out->part = 0;
    out->pdf = 1.0f;
    if (out->delta) return true;
    const struct rnd_v3_frame frame = rnd_v3_frame(sun->direction);
    out->direction = rnd_sun_draw(sun, &frame, u[2], u[3]);
    out->pdf = rnd_sun_pdf(sun);
    return true;
}

bool rnd_sun_build(struct rnd_scene *scene, double *out_power)
{
    const struct rnd_sun *sun = scene->lights.sun;
    *out_power = sun ? (double)rnd_v3_luminance(sun->radiance) : 0.0;
    return true;
}
