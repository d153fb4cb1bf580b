/* Reconstructions: what a client is shown of the paths so far. One file a method. */
#ifndef FOVEAD_RENDERER_RECONSTRUCTION_H
#define FOVEAD_RENDERER_RECONSTRUCTION_H

#include "film/sums.h"

/* What a reconstruction works on: the pixels of a tile at a level, and those around it up to the row's
 * radius. They go on across the seam of the panorama, and over a pole on the opposite meridian. */
struct rnd_window {
    int level, x, y;             /* the tile */
    int side;                    /* pixels: RND_TILE, and the radius twice */
    const struct rnd_sum *pixel; /* side x side, row by row */
    /* The planes that the row asks for, pixel by pixel: see rnd_window_plane(). */
    const struct rnd_planes *planes;
    const float *values;
    struct rnd_camera camera;       /* of the paths */
    uint32_t generation;            /* of the film */
    const struct rnd_film *history; /* see rnd_window_history() */
};

/* The channels of a plane at pixel i of a window: means over the parts of its area that have paths; 0
 * where none has. The row asks for that plane. */
static inline const float *rnd_window_plane(const struct rnd_window *window, enum rnd_plane_id plane, int i)
{
    return window->values + i * window->planes->channels + window->planes->first[plane];
}

/* For a row that keeps history: the tile (x, y) of a level as a former camera saw it, which is in
 * out_sums, and the planes that the row asks for (RND_TILE x RND_TILE x planes->channels floats; may be
 * NULL). There is history from a move of the camera on, until the film has as many paths as the former one
 * had; of several moves in between, the film with the most paths is kept. It ends when the scene changes.
 * False if there is none of that tile, or if the tile cannot be read just now. */
bool rnd_window_history(const struct rnd_window *window, int level, int x, int y, struct rnd_sums *out_sums,
                        float *out_planes);

/* A way to show a film. It is consistent: what it shows of a pixel goes to the pixel's mean as paths grow. */
struct rnd_reconstruction {
    const char *name;    /* as an option names it */
    const char *summary; /* half a line */
    const char *source;  /* author, year */
    uint32_t planes;     /* that it needs: a set, RND_PLANE(ALBEDO) | ... (film/planes.h) */
    int radius;          /* pixels that it looks at beyond a tile, at every level: 0 to RND_TILE */
    bool keeps_history;  /* a second film: rnd_window_history() */
    /* Prepare for a film of that many pixels: *out_memory is for the calls below. False if memory is short.
     * NULL: the row needs no memory. */
    bool (*begin)(int width, int height, void **out_memory);
    /* Fill RND_TILE x RND_TILE x RGB floats, radiance. False if nothing can be shown yet. Several threads may
     * call it at once. */
    bool (*run)(void *memory, const struct rnd_window *window, float *out_rgb);
    void (*end)(void *memory); /* NULL where begin is */
};

/* The table of reconstructions, the default first. Another one is a file, and a line here. */
#define RND_RECONSTRUCTIONS(row) row(pull_push)

#define RND_RECONSTRUCTION_DECLARE(name) extern const struct rnd_reconstruction rnd_reconstruction_##name;
RND_RECONSTRUCTIONS(RND_RECONSTRUCTION_DECLARE)

/* By index from 0. NULL if there is none. */
const struct rnd_reconstruction *rnd_reconstruction_at(size_t index);

#endif
