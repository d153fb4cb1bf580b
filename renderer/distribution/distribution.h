/* The distributions, one per file. */
#ifndef FOVEAD_RENDERER_DISTRIBUTION_H
#define FOVEAD_RENDERER_DISTRIBUTION_H

#include "renderer.h"

/* The table of distributions. Another one is a file, and a name here. */
#define RND_DISTRIBUTIONS(row) row(fv) row(fv_exact) row(vp) row(od)

#define RND_DISTRIBUTION_DECLARE(name) extern const struct rnd_distribution rnd_distribution_##name;
RND_DISTRIBUTIONS(RND_DISTRIBUTION_DECLARE)

#endif
