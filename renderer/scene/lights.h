/* Lights of a scene, as data: emissive triangles, environment, sun, punctual lights. light/ has a file for
 * what each kind does. */
#ifndef FOVEAD_RENDERER_LIGHTS_H
#define FOVEAD_RENDERER_LIGHTS_H

#include "math/alias.h"
#include "math/v3.h"

/* --- environment ---
 *
 * First a region is drawn, then a texel in it by its weight: luminance times solid angle. Regions are drawn
 * by the weight of their texels, or by the share of that weight which is known to arrive (path/survey.c). */

enum { RND_ENV_COLUMNS = 32, RND_ENV_ROWS = 16, RND_ENV_REGIONS = RND_ENV_COLUMNS * RND_ENV_ROWS };

/* How often each region is drawn. */
struct rnd_env_choice {
    struct rnd_alias_entry entry[RND_ENV_REGIONS]; /* an alias table */
    float factor[RND_ENV_REGIONS]; /* of each region: its probability over the one by weight */
};

struct rnd_env {
    int width, height;
    float turn;        /* added to u before the look-up */
    float (*texel)[4]; /* row by row: radiance, and the density of drawing it by weight, per steradian, times
                          the cosine of the latitude */
    struct rnd_env_region {
        uint32_t first, texels; /* of its entries, one for each texel */
        int32_t x, y, width;    /* in the map */
    } region[RND_ENV_REGIONS];
    struct rnd_alias_entry *entry;   /* for each region an alias table of its texels, row by row; other is an
                                      index in texel */
    float weight[RND_ENV_REGIONS];   /* of regions; the sum is 1 */
    struct rnd_env_choice by_weight; /* with factors of 1 */
};

/* --- sun --- */

struct rnd_sun {
    struct rnd_v3 direction; /* towards the sun */
    struct rnd_v3 radiance;  /* within its disc; irradiance when it is a point */
    float drop;              /* 1 - cosine of its angular radius; 0: a point */
};

/* --- emissive triangles and punctual lights --- */

/* A triangle, or a part of one: only what drawing it needs, as many are looked up at random. */
struct rnd_area {
    struct rnd_v3 corner, e1, e2;
    struct rnd_v3 emission; /* without its texture */
    uint32_t mesh, triangle;
    uint32_t flags; /* RND_AREA_... */
    /* If it is divided, the index of its first part; the other three follow. Else the corner's barycentric
     * coordinates in the triangle, u | v << 16, in steps of the part's sides. */
    uint32_t place;
};
_Static_assert(sizeof(struct rnd_area) == 64, "an area is a line of the cache");
enum {
    RND_AREA_TEXTURED = 1,
    RND_AREA_DOUBLE = 2,
    RND_AREA_COVERED = 4, /* has coverage below 1 somewhere */
    RND_AREA_DIVIDED = 8, /* its parts are drawn in its place */
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

/* Emitters of a group, emissive triangles or punctual lights: a table by power, and parts of emitters that
 * are near each other. */
enum { RND_LIGHT_PARTS = 256 };
struct rnd_emitters {
    struct rnd_alias by_power;
    uint16_t *part; /* of each emitter, the part that it is in */
};

struct rnd_lights {
    bool has[RND_LIGHT_GROUPS]; /* does the group give light? */
    bool any;                   /* does one of them? */
    uint32_t area_count;
    bool area_uneven; /* some have a texture, or coverage below 1 somewhere */
    struct rnd_area *area;
    struct rnd_env *env;
    struct rnd_sun *sun;
    uint32_t punctual_count;
    struct rnd_punctual *punctual;
    struct rnd_emitters emitters[RND_LIGHT_GROUPS]; /* of emissive triangles and punctual lights */
};

#endif
