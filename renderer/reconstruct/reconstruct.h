/* Running a reconstruction on a film. */
#ifndef FOVEAD_RENDERER_RECONSTRUCT_H
#define FOVEAD_RENDERER_RECONSTRUCT_H

#include "reconstruct/reconstruction.h"

/* A reconstruction at work. */
struct rnd_reconstructor {
    const struct rnd_reconstruction *row;
    const struct rnd_film *film, *history; /* NULL: no history */
    void *memory;                          /* of the row's own */
};

/* The films must outlive the reconstructor; history is NULL unless the row keeps it. False if memory is
 * short; finish it in any case. */
bool rnd_reconstructor_init(struct rnd_reconstructor *reconstructor, const struct rnd_reconstruction *row,
                            const struct rnd_film *film, const struct rnd_film *history);
void rnd_reconstructor_finish(struct rnd_reconstructor *reconstructor);

/* See rnd_render_read(). False also if memory is short. */
bool rnd_reconstruct(const struct rnd_reconstructor *reconstructor, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state);

#endif
