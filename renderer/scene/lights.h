/* Lights of a scene, as data: emissive triangles, environment, sun, punctual lights. light/ has a file for
 * what each kind does. */
#ifndef FOVEAD_RENDERER_LIGHTS_H
#define FOVEAD_RENDERER_LIGHTS_H

#include "math/alias.h"
#include "math/v3.h"

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

/* --- sun --- */

struct rnd_sun {
    struct rnd_v3 direction; /* towards it */
    struct rnd_v3 radiance;  /* within its disc; irradiance when it is a point */
    float drop;              /* 1 - cosine of its angular radius; 0: a point */
};

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
struct rnd_emitters {
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
    struct rnd_emitters emitters[RND_LIGHT_GROUPS]; /* of emissive triangles and punctual lights */
};

#endif
