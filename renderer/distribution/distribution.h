/* The distributions, one per file. table.c has the table. */
#ifndef FOVEAD_RENDERER_DISTRIBUTION_H
#define FOVEAD_RENDERER_DISTRIBUTION_H

#include "renderer.h"

extern const struct rnd_distribution rnd_distribution_od;
extern const struct rnd_distribution rnd_distribution_vp;
extern const struct rnd_distribution rnd_distribution_fv;
extern const struct rnd_distribution rnd_distribution_fv_exact;

#endif
