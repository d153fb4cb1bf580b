/* A reader of pictures for a scene. */
#ifndef FOVEAD_RENDERER_PICTURES_H
#define FOVEAD_RENDERER_PICTURES_H

#include "import/image_apart.h"
#include "scene/scene.h"

/* The caller finishes it. */
static inline struct rnd_image_reader rnd_scene_reader(const struct rnd_scene *scene)
{
    return (struct rnd_image_reader){.program = scene->image_program,
                                     .limits = {scene->reader_mib, scene->reader_seconds},
                                     .cancel = {&scene->cancelled, scene->cancel},
                                     .socket = -1};
}

#endif
