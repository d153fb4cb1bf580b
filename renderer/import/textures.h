/* Reading the textures of a scene. */
#ifndef FOVEAD_RENDERER_TEXTURES_H
#define FOVEAD_RENDERER_TEXTURES_H

#include "scene/scene.h"

struct rnd_image_reader;

/* Read the file, and make the mipmaps. False on failure; texture->error says why. */
bool rnd_texture_load(struct rnd_texture *texture, struct rnd_image_reader *reader);
/* Read those that were added and not read yet: all, or those that are marked as first. Those that cannot be
 * read say why in their error. All together take 2 GiB at most, and the largest do without their finest
 * levels. */
void rnd_textures_load(struct rnd_scene *scene, bool first);
/* Take images that cannot be read from the scene's materials, with a warning of each file. */
void rnd_textures_drop_unread(struct rnd_scene *scene, struct rnd_warnings *warnings);
/* Tell what they take. */
void rnd_textures_sum(struct rnd_scene *scene);

#endif
