/* Textures: read once each, looked up bilinearly. */
#include "scene/scene.h"
#include "scene/srgb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TEXTURE_BYTES_SHIFT = 32 }; /* 4 GiB of texels in all */

int rnd_texture_add(struct rnd_scene *scene, const char *path, const void *memory, size_t count, bool srgb,
                    char out_error[RND_ERROR_SIZE])
{
    for (uint32_t i = 0; i < scene->texture_count; i++)
        if (scene->texture[i].srgb == srgb && strcmp(scene->texture[i].path, path) == 0) return (int)i;

    struct rnd_texture texture = {.srgb = srgb};
    char text[RND_ERROR_SIZE / 2];
    if (!rnd_pixels_read(path, memory, count, true, &texture.pixels, text, sizeof text)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not a readable image: %s", path, text);
        return -1;
    }
    const uint64_t bytes = (uint64_t)texture.pixels.width * texture.pixels.height * texture.pixels.channels *
                           (texture.pixels.bytes ? 1 : sizeof(float));
    struct rnd_texture *grown = realloc(scene->texture, (scene->texture_count + 1) * sizeof *grown);
    if (grown) scene->texture = grown;
    texture.path = strdup(path);
    if (!grown || !texture.path || (scene->info.texture_bytes + bytes) >> MAX_TEXTURE_BYTES_SHIFT) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: textures over 4 GiB in all, or not enough memory", path);
        free(texture.path);
        rnd_pixels_finish(&texture.pixels);
        return -1;
    }
    scene->info.texture_bytes += bytes;
    scene->texture[scene->texture_count] = texture;
    return (int)scene->texture_count++;
}

static vec3s texel(const struct rnd_texture *texture, int x, int y)
{
    const struct rnd_pixels *p = &texture->pixels;
    const size_t i = ((size_t)y * p->width + x) * p->channels, g = p->channels >= 3 ? 1 : 0, b = 2 * g;
    if (p->floats) return (vec3s){{p->floats[i], p->floats[i + g], p->floats[i + b]}};
    if (texture->srgb)
        return (vec3s){{rnd_srgb_decode(p->bytes[i]), rnd_srgb_decode(p->bytes[i + g]),
                        rnd_srgb_decode(p->bytes[i + b])}};
    return glms_vec3_scale((vec3s){{p->bytes[i], p->bytes[i + g], p->bytes[i + b]}}, 1.0f / 255.0f);
}

vec3s rnd_texture_rgb(const struct rnd_texture *texture, float u, float v)
{
    const int w = texture->pixels.width, h = texture->pixels.height;
    const float x = (u - floorf(u)) * w - 0.5f, y = (v - floorf(v)) * h - 0.5f;
    const int x0 = (int)floorf(x), y0 = (int)floorf(y);
    const float fx = x - x0, fy = y - y0;
    const int xs[2] = {(x0 + w) % w, (x0 + 1) % w}, ys[2] = {(y0 + h) % h, (y0 + 1) % h};
    const vec3s upper = glms_vec3_lerp(texel(texture, xs[0], ys[0]), texel(texture, xs[1], ys[0]), fx);
    const vec3s lower = glms_vec3_lerp(texel(texture, xs[0], ys[1]), texel(texture, xs[1], ys[1]), fx);
    return glms_vec3_lerp(upper, lower, fy);
}

vec3s rnd_emission(const struct rnd_scene *scene, const struct rnd_material *material,
                   const struct rnd_mesh *mesh, const uint32_t index[3], float u, float v)
{
    if (material->map[RND_MAP_EMISSION].texture < 0 || !mesh->uv[0]) return material->emission;
    const float s = rnd_interpolate(mesh->uv[0], 2, 0, index, u, v),
                t = rnd_interpolate(mesh->uv[0], 2, 1, index, u, v);
    return glms_vec3_mul(material->emission,
                         rnd_texture_rgb(&scene->texture[material->map[RND_MAP_EMISSION].texture], s, t));
}
