/* A render in progress. */
#ifndef FOVEAD_RENDERER_RENDER_H
#define FOVEAD_RENDERER_RENDER_H

#include "film/tile.h"
#include "path/integrator.h"
#include "reconstruct/reconstruct.h"

struct rnd_render {
    struct rnd_film film;
    struct rnd_film history; /* paths of a former camera; without memory unless the reconstruction keeps it */
    struct rnd_integrator integrator;
    struct rnd_reconstructor reconstructor; /* of what is shown of the film */
    pthread_mutex_t whole; /* held while the film is read as a whole, and while it is emptied */
    uint32_t generation;   /* of the film, from 1: each restart begins the next */
    /* Of the scene, when the film was begun: textures that come later bring other ones. */
    const struct rnd_material *material;
    struct rnd_image_program *image_program; /* of the first scene; it stays when the scene changes */
};

#endif
