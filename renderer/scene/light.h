/* Lights of a scene: emissive triangles, environment, sun, punctual lights; drawn one at a time for
 * next-event estimation. A shading point chooses a group, then a light within the group: by power, or by what
 * of that is known to arrive (path/survey.c). */
#ifndef FOVEAD_RENDERER_LIGHT_H
#define FOVEAD_RENDERER_LIGHT_H

#include "math/alias.h"
#include "math/uv.h"
#include "renderer.h"

struct rnd_scene;

/* --- environment ---
 *
 * First a region is drawn, then a texel in it by luminance and solid angle. Regions are drawn by what all
 * their texels weigh, or by what of that is known to arrive (path/survey.c). */

enum { RND_ENV_COLUMNS = 32, RND_ENV_ROWS = 16, RND_ENV_REGIONS = RND_ENV_COLUMNS * RND_ENV_ROWS };

/* Which region is drawn how often. */
struct rnd_env_choice {
    struct rnd_alias_entry entry[RND_ENV_REGIONS]; /* an alias table */
    float factor[RND_ENV_REGIONS]; /* of each: its probability over that by the weight of its texels */
};

struct rnd_env {
    int width, height;
    float turn;        /* what is added to u before the look-up */
    float (*texel)[4]; /* row by row: radiance, and the density of drawing it by weight, per steradian, times
                          the cosine of the latitude */
    struct rnd_env_region {
        uint32_t first, texels; /* its own among the entries */
        int32_t x, y, width;    /* in the map */
    } region[RND_ENV_REGIONS];
    struct rnd_alias_entry *entry; /* an alias table a region, of its texels row by row; others are texels of
                                      the map */
    float weight[RND_ENV_REGIONS]; /* of regions; the sum is 1 */
    struct rnd_env_choice by_weight; /* with factors of 1 */
};

/* env.c: read the scene's environment map. out_warning is a line about pixels that are no radiance, or "".
 * False and a line in out_error. */
bool rnd_env_load(struct rnd_scene *scene, const char *path, float azimuth_deg,
                  char out_warning[RND_ERROR_SIZE], char out_error[RND_ERROR_SIZE]);

/* The texel of a direction, its bilinear neighbours chosen by two numbers in [0,1): the mean over them is the
 * interpolated radiance; with 1/2 and 1/2 it is the texel that the direction falls into. */
RND_INLINE uint32_t rnd_env_texel(const struct rnd_env *env, float u, float v, float r, float s)
{
    const float x = u * (float)env->width - 0.5f + r, y = v * (float)env->height - 0.5f + s;
    int32_t ix = (int32_t)floorf(x), iy = (int32_t)floorf(y);
    ix = ix < 0 ? ix + env->width : ix;
    ix = ix >= env->width ? ix - env->width : ix;
    iy = iy < 0 ? 0 : iy;
    iy = iy >= env->height ? env->height - 1 : iy;
    return (uint32_t)(iy * env->width + ix);
}

/* The region of the texel that (u, v) falls into: its borders are those of texels. */
RND_INLINE uint32_t rnd_env_region(const struct rnd_env *env, float u, float v)
{
    const float x = rnd_smaller(floorf(u * (float)env->width), (float)(env->width - 1)),
                y = rnd_smaller(floorf(v * (float)env->height), (float)(env->height - 1));
    const int32_t column = (int32_t)((x + 0.5f) * (RND_ENV_COLUMNS / (float)env->width)),
                  row = (int32_t)((y + 0.5f) * (RND_ENV_ROWS / (float)env->height));
    return (uint32_t)(row * RND_ENV_COLUMNS + column);
}

/* Draw a region, by u in [0,1) whose bits below 2^-24 are v in [0,1), and an entry of it; rnd_env_texel_of()
 * says which of its two texels is drawn. */
RND_INLINE uint32_t rnd_env_place(const struct rnd_env *env, const struct rnd_env_choice *choice, float u,
                                  float v, uint32_t *out_region, float *out_part)
{
    const double place = ((double)u + (double)v * 0x1p-24) * RND_ENV_REGIONS;
    const uint32_t drawn = (uint32_t)place < RND_ENV_REGIONS ? (uint32_t)place : RND_ENV_REGIONS - 1;
    const struct rnd_alias_entry *entry = &choice->entry[drawn];
    const double part = place - drawn, keep = (double)entry->keep;
    const bool own = part < keep;
    const uint32_t number = *out_region = own ? drawn : entry->other;
    const struct rnd_env_region *region = &env->region[number];
    const double rest = (own ? part / keep : (part - keep) / (1.0 - keep)) * region->texels;
    const uint32_t i = rest < region->texels ? (uint32_t)rest : region->texels - 1;
    *out_part = (float)(rest - i);
    return region->first + i;
}

RND_INLINE uint32_t rnd_env_texel_of(const struct rnd_env *env, uint32_t region, uint32_t place, float part)
{
    const struct rnd_env_region *r = &env->region[region];
    const uint32_t i = place - r->first, width = (uint32_t)r->width;
    if (!(part < env->entry[place].keep)) return env->entry[place].other;
    return ((uint32_t)r->y + i / width) * (uint32_t)env->width + (uint32_t)r->x + i % width;
}

RND_INLINE void rnd_env_to_uv(const struct rnd_env *env, struct rnd_v3 direction, float *out_u, float *out_v)
{
    rnd_v3_to_uv(direction, out_u, out_v);
    const float u = *out_u + env->turn;
    *out_u = u - floorf(u);
}

/* Direction at a place within a texel, and its density per steradian but for the choice of group. */
RND_INLINE struct rnd_v3 rnd_env_direction(const struct rnd_env *env, uint32_t texel, float r, float s,
                                           float *out_u, float *out_v)
{
    /* vectors have no division of integers; this one is exact below 2^31 */
    const int32_t i = (int32_t)texel, row = (int32_t)(((double)i + 0.5) / env->width);
    const float u = ((float)(i - row * env->width) + r) / (float)env->width;
    *out_u = u;
    *out_v = ((float)row + s) / (float)env->height;
    const float turned = u - env->turn;
    return rnd_v3_from_uv(turned - floorf(turned), *out_v);
}

/* Radiance from a direction, the texel that it falls into; its region; and the density with which it is drawn
 * by weight. */
struct rnd_v3 rnd_env_radiance(const struct rnd_env *env, struct rnd_v3 direction, uint32_t *out_region,
                               float *out_pdf);

/* Draw regions with these probabilities, of any sum above 0: 0 for those without weight, and for those alone.
 * False if memory is short. */
bool rnd_env_choose(const struct rnd_env *env, const float probability[RND_ENV_REGIONS],
                    struct rnd_env_choice *out);

/* --- sun --- */

struct rnd_sun {
    struct rnd_v3 direction; /* towards it */
    struct rnd_v3 radiance;  /* within its disc; irradiance when it is a point */
    float drop;              /* 1 - cosine of its angular radius; 0: a point */
};

void rnd_sun_init(struct rnd_sun *sun, const float options[4]);

/* 1 - cosine of the angle between two unit vectors: half the square of what is between their ends. To
 * subtract a cosine from 1 would round all angles below 0.02 degrees to nothing. */
RND_INLINE float rnd_drop(struct rnd_v3 a, struct rnd_v3 b)
{
    const struct rnd_v3 chord = rnd_v3_sub(a, b);
    return 0.5f * rnd_v3_dot(chord, chord);
}

/* The same of an angle, rad. */
static inline float rnd_drop_of(double angle)
{
    const double s = sin(0.5 * angle);
    return (float)(2.0 * s * s);
}

/* Within its disc, per steradian. */
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

/* --- emissive triangles and punctual lights --- */

/* A triangle, or a part of one. All that drawing one asks for, and no more: so many are looked up all over.
 */
struct rnd_area {
    struct rnd_v3 corner, e1, e2;
    struct rnd_v3 emission; /* but for its texture */
    uint32_t mesh, triangle;
    uint32_t flags; /* RND_AREA_... */
    /* Of one that is divided, the first of its four parts. Else where the corner is in the triangle: its
     * barycentric u, v << 16, in steps of the part's sides. */
    uint32_t place;
};
_Static_assert(sizeof(struct rnd_area) == 64, "an area is a line of the cache");
enum {
    RND_AREA_TEXTURED = 1,
    RND_AREA_DOUBLE = 2,
    RND_AREA_COVERED = 4, /* not there everywhere */
    RND_AREA_DIVIDED = 8, /* not drawn itself, but its parts */
    RND_AREA_TURNED = 16, /* a part whose sides run against the triangle's */
    RND_AREA_HALVINGS = 8 /* bits from here on: how often the triangle's sides were halved */
};

struct rnd_punctual {
    struct rnd_v3 position;  /* m; spot and point */
    struct rnd_v3 direction; /* where it shines; spot and directional */
    struct rnd_v3 intensity; /* W/sr; directional: irradiance W/m^2 */
    enum { RND_POINT, RND_SPOT, RND_DIRECTIONAL } kind;
    float drop_inner, drop_outer; /* spot: rnd_drop_of() its angles */
};

/* --- all --- */

/* Groups that a shading point chooses between before it chooses a light. */
enum { RND_LIGHT_AREA, RND_LIGHT_ENV, RND_LIGHT_SUN, RND_LIGHT_PUNCTUAL, RND_LIGHT_GROUPS };

/* Emissive triangles or punctual lights: a table by power, and parts of them that are near each other. */
enum { RND_LIGHT_PARTS = 256 };
struct rnd_lamps {
    struct rnd_alias by_power;
    uint16_t *part; /* of each */
};

struct rnd_lights {
    bool has[RND_LIGHT_GROUPS]; /* does the group give light? */
    bool any;                   /* does one of them? */
    uint32_t area_count;
    bool area_uneven; /* some are textured, or not there everywhere */
    struct rnd_area *area;
    struct rnd_env *env;
    struct rnd_sun *sun;
    uint32_t punctual_count;
    struct rnd_punctual *punctual;
    struct rnd_lamps lamps[RND_LIGHT_GROUPS]; /* of emissive triangles and punctual lights */
};

/* How often points ask for which light. */
struct rnd_light_choice {
    float group[RND_LIGHT_GROUPS];                   /* one in all; never 0 for one that gives light */
    struct rnd_env_choice env;                       /* unused without an environment */
    const struct rnd_alias *lamps[RND_LIGHT_GROUPS]; /* the lights' own, or these: */
    struct rnd_alias own[RND_LIGHT_GROUPS];
};

/* Every group as often, and by power within it. choice is one that was in use, or zeros. */
void rnd_light_choose_evenly(const struct rnd_lights *lights, struct rnd_light_choice *choice);
void rnd_light_choice_finish(struct rnd_light_choice *choice);

/* A light of a group seen from a point: where to look for it, what comes from there, with which density it
 * was drawn within the group. */
struct rnd_light_sample {
    struct rnd_v3 direction; /* unit, towards the light */
    float distance;          /* INFINITY for env and sun */
    struct rnd_v3 radiance;  /* for lights without extent, the irradiance facing it */
    float pdf;               /* per steradian; for lights without extent, of the choice alone */
    bool delta;              /* no extent: cannot be hit by chance */
    uint32_t part;           /* of lamps, or region of the environment */
};

/* emitter.c: find the emissive triangles and divide them: fills the lights' areas, and marks the meshes.
 * *out_weight: by which each area is to be drawn; the caller frees. False if memory is short. */
bool rnd_emitters_build(struct rnd_scene *scene, float **out_weight);

/* After the geometry: find what emits and make the tables. */
bool rnd_lights_build(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE]);
void rnd_lights_finish(struct rnd_lights *lights);

/* Draw a light of a group for the point from four numbers in [0,1). False if what was drawn does not reach
 * it. */
bool rnd_light_draw(const struct rnd_scene *scene, const struct rnd_light_choice *choice, int group,
                    struct rnd_v3 point, const float u[4], struct rnd_light_sample *out);

/* Emitted radiance at barycentric (u, v) of the area's triangle, as a ray that hits it sees it. */
struct rnd_v3 rnd_area_emission(const struct rnd_scene *scene, const struct rnd_area *area, float u, float v);
/* The same at barycentric (s, t) of the area itself, times its coverage there. */
struct rnd_v3 rnd_area_gives(const struct rnd_scene *scene, const struct rnd_area *area, float s, float t);

/* From barycentric coordinates of an area to those of its triangle. */
RND_INLINE void rnd_area_place(const struct rnd_area *area, float s, float t, float *out_u, float *out_v)
{
    const float side = 1.0f / (float)(1u << (area->flags >> RND_AREA_HALVINGS)),
                turn = area->flags & RND_AREA_TURNED ? -1.0f : 1.0f;
    *out_u = side * ((float)(area->place & 0xffffu) + turn * s);
    *out_v = side * ((float)(area->place >> 16) + turn * t);
}

/* The area that is drawn at barycentric (u, v) of triangle i: i itself or a part of it. */
RND_INLINE uint32_t rnd_area_at(const struct rnd_lights *lights, uint32_t i, float u, float v)
{
    while (lights->area[i].flags & RND_AREA_DIVIDED) {
        const int k = u >= 0.5f ? 1 : v >= 0.5f ? 2 : u + v <= 0.5f ? 0 : 3;
        u = k == 3 ? 1.0f - 2.0f * u : 2.0f * u - (k == 1 ? 1.0f : 0.0f);
        v = k == 3 ? 1.0f - 2.0f * v : 2.0f * v - (k == 2 ? 1.0f : 0.0f);
        i = lights->area[i].place + (uint32_t)k;
    }
    return i;
}

/* A triangle seen so nearly from its side gives nothing but rounding: it is not drawn from there. */
#define RND_LEAST_COSINE 1e-6f

/* Density per steradian of drawing the point of a triangle that is seen at a distance along a direction, if
 * the triangle is drawn with that probability. */
RND_INLINE float rnd_area_pdf(const struct rnd_area *area, float probability, struct rnd_v3 direction,
                              float distance)
{
    const struct rnd_v3 twice = rnd_v3_cross(area->e1, area->e2);
    const float projected = fabsf(rnd_v3_dot(twice, direction)); /* twice the area, times the cosine */
    const float least = RND_LEAST_COSINE * RND_LEAST_COSINE * rnd_v3_dot(twice, twice);
    const float pdf = probability * distance * distance / (0.5f * rnd_larger(projected, 1e-37f));
    return (projected * projected > least) & (pdf < INFINITY) ? pdf : 0.0f;
}

/* Draw a point of a triangle as seen from a point, by two numbers in [0,1): its direction, distance and
 * barycentric coordinates. Returns the density as rnd_area_pdf() does, 0 if the triangle does not shine
 * there. */
RND_INLINE float rnd_area_draw(const struct rnd_area *area, float probability, struct rnd_v3 point, float u,
                               float v, struct rnd_v3 *out_direction, float *out_distance, float *out_s,
                               float *out_t)
{
    const float root = sqrtf(u), s = v * root, t = root - s; /* uniform over the triangle */
    const struct rnd_v3 p = rnd_v3_muladd(area->e2, t, rnd_v3_muladd(area->e1, s, area->corner)),
                        to = rnd_v3_sub(p, point);
    const float distance = sqrtf(rnd_v3_dot(to, to));
    *out_direction = rnd_v3_scale(to, 1.0f / rnd_larger(distance, 1e-37f));
    *out_distance = distance;
    *out_s = s;
    *out_t = t;
    const float facing = rnd_v3_dot(rnd_v3_cross(area->e1, area->e2), *out_direction);
    const int shines = (facing < 0.0f) | ((area->flags & RND_AREA_DOUBLE) != 0);
    const float pdf = rnd_area_pdf(area, probability, *out_direction, distance);
    return shines & (distance > 0.0f) ? pdf : 0.0f;
}

/* Weight of a direction drawn with density pdf that another way would draw with density other (Veach 1997,
 * power heuristic with exponent 2). */
RND_INLINE float rnd_power_heuristic(float pdf, float other)
{
    const float r = other / pdf;
    return 1.0f / (1.0f + r * r);
}

#endif
