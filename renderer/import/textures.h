/* Reading the textures of a scene. */
#ifndef FOVEAD_RENDERER_TEXTURES_H
#define FOVEAD_RENDERER_TEXTURES_H

#include "scene/scene.h"

struct rnd_image_reader;

/* Read the file, and make the mipmaps. False on failure; texture->error says why. */
bool rnd_texture_load(struct rnd_texture *texture, struct rnd_image_reader *reader);
/* Read textures that were added and not read yet: all, or only those that are marked as first. The error of
 * each says why it cannot be read. All together take at most 2 GiB; for that the largest lose their finest
 * levels. */
void rnd_textures_load(struct rnd_scene *scene, bool first);
/* Remove images that cannot be read from the scene's materials, with a warning for each file. */
void rnd_textures_drop_unread(struct rnd_scene *scene, struct rnd_warnings *warnings);
/* Set the texture_bytes of the scene's info. */
void rnd_textures_sum(struct rnd_scene *scene);

#endif
