/* Planes: what the film keeps of the first surfaces of its paths, beside their radiance.
 *
 * A film has the planes that its reconstruction or its user asks for, and no others. A path's values are
 * gathered where its first ray has hit a surface; a path that hits nothing has 0 in every plane. So a mean
 * over the paths of a pixel is the mean over those that hit, times the plane "coverage".
 */
#ifndef FOVEAD_RENDERER_PLANES_H
#define FOVEAD_RENDERER_PLANES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct rnd_surface;

/* Names of the rows of the table, in the order of rnd_plane_at(). */
enum rnd_plane_id {
    RND_PLANE_ALBEDO,   /* base colour: with textures and vertex colours */
    RND_PLANE_NORMAL,   /* shading normal in the world, facing the camera; the mean is not of unit length */
    RND_PLANE_POSITION, /* m, in the scene's own coordinates, as the camera's position */
    RND_PLANE_COVERAGE, /* share of the paths that hit a surface */
    RND_PLANE_INSTANCE, /* number of the mesh or instance that was hit, from 1: exact up to 2^24; 0: none */
    RND_PLANES,
};

/* Planes as a set. */
#define RND_PLANE(id) (1u << RND_PLANE_##id)

enum { RND_PLANE_MOST_CHANNELS = 3 * RND_PLANES };

/* How a pixel keeps a plane. */
enum rnd_plane_form {
    RND_PLANE_HALVES, /* mean over its paths, as half floats: to about 0.1 % */
    RND_PLANE_FLOATS, /* mean over its paths, as floats */
    RND_PLANE_LAST,   /* of the path that was added last, as floats: numbers that have no mean */
};

struct rnd_plane {
    const char *name;       /* as an option names it */
    const char *summary;    /* half a line */
    int channels;           /* up to 3 */
    const char *channel[3]; /* their names in files */
    enum rnd_plane_form form;
    /* The channels of a path that hit that surface of the mesh or instance of that number. */
    void (*gather)(const struct rnd_surface *surface, uint32_t instance, float *out);
};

/* The planes of a film, and how the record of a pixel holds them. */
struct rnd_planes {
    int channels;   /* of all of them; 0: the film has no planes */
    uint32_t bytes; /* of a pixel's record */
    uint8_t plane[RND_PLANE_MOST_CHANNELS],
        at[RND_PLANE_MOST_CHANNELS]; /* of a channel: row, place in bytes */
    int first[RND_PLANES];           /* channel of each plane; -1: the film does not have it */
};

/* asked: a set of planes. */
void rnd_planes_init(struct rnd_planes *planes, uint32_t asked);

/* The name of a channel in files; *out_floats: halves would not hold its values. */
const char *rnd_planes_channel(const struct rnd_planes *planes, int channel, bool *out_floats);

/* The values of a path, planes->channels of them. What is not finite becomes 0. */
void rnd_planes_gather(const struct rnd_planes *planes, const struct rnd_surface *surface, uint32_t instance,
                       float *out);

/* --- memory of a tile: floats for its blocks, and then a record for each pixel --- */

size_t rnd_planes_size(const struct rnd_planes *planes, uint32_t pixels, uint32_t blocks); /* bytes */

/* Add a path's values to a pixel that has so many paths before it, and to its block. Records mean nothing
 * before their first path, and blocks must be 0. A block holds the sum of its pixels' means. */
void rnd_planes_add(const struct rnd_planes *planes, void *record, float *block, uint32_t paths,
                    const float *values);
/* Add a pixel's values to a sum, or the mean of a block's pixels, of which so many have paths. Of a plane
 * that has no mean, the last one counts. */
void rnd_planes_sum(const struct rnd_planes *planes, const void *record, float *sum);
void rnd_planes_sum_block(const struct rnd_planes *planes, const float *block, uint32_t pixels, float *sum);
/* Make a sum of so many values a mean. */
void rnd_planes_divide(const struct rnd_planes *planes, float count, float *sum);

#endif
