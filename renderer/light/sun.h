/* The sun: a disc, or a point, infinitely far away. */
#ifndef FOVEAD_RENDERER_SUN_H
#define FOVEAD_RENDERER_SUN_H

#include "light/choice.h"
#include "scene/scene.h"

#include <math.h>

/* options as struct rnd_scene_options has them. */
void rnd_sun_init(struct rnd_sun *sun, const float options[4]);

/* Density per steradian of a direction within the disc. */
RND_INLINE float rnd_sun_pdf(const struct rnd_sun *sun)
{
    return 1.0f / (2.0f * (float)M_PI * sun->drop);
}

/* A direction within its disc; frame is rnd_v3_frame() of its direction. */
RND_INLINE struct rnd_v3 rnd_sun_draw(const struct rnd_sun *sun, const struct rnd_v3_frame *frame, float u,
                                      float v)
{
    const float drop = u * sun->drop, r = sqrtf(rnd_larger(drop * (2.0f - drop), 0.0f));
    float sine, cosine;
    rnd_turn(v, &sine, &cosine);
    return rnd_v3_to_world(frame, rnd_v3(r * cosine, r * sine, 1.0f - drop));
}

/* rnd_light_kind.build and .draw. */
bool rnd_sun_build(struct rnd_scene *scene, double *out_power);
bool rnd_sun_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                   const float u[4], struct rnd_light_sample *out);

#endif
