/* Materials of MTL, and of other formats for which assimp uses the same keys. */
#include "import/mtl_material.h"
#include "import/find_file.h"
#include "material/material.h"

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The material that is being read. */
struct reader {
    struct rnd_import *in;
    const struct aiScene *file;
    const struct aiMaterial *from;
    const struct rnd_mtl_material *lines; /* the material in its library, or NULL */
    const char *library;                  /* directory of the library, "" or with a slash at its end */
};

/* --- maps --- */

static uint8_t wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal ? RND_CLAMP
           : mode == aiTextureMapMode_Mirror                                ? RND_MIRROR
                                                                            : RND_REPEAT;
}

/* Warn of an image that cannot be read. */
static bool go_without(struct reader *r, const char *name, const char *why)
{
    rnd_warn(&r->in->scene->warnings, "%.200s: %s: %s; the material's factor is used alone", r->in->path,
             name, why);
    return true;
}

/* False if memory is short. */
static bool read_map(struct reader *r, enum aiTextureType type, enum rnd_map_use use,
                     enum rnd_pixels_use pixels, struct rnd_material *to)
{
    struct aiString name;
    unsigned channel = 0;
    enum aiTextureMapMode mode[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    struct rnd_map *map = &to->map[use];
    if (aiGetMaterialTexture(r->from, type, 0, &name, NULL, &channel, NULL, NULL, mode, NULL) !=
        aiReturn_SUCCESS)
        return true;
    if (channel > 1) rnd_scene_unsupported(r->in->scene, "texture coordinates beyond the second set");
    map->uv_set = channel == 1;
    map->wrap[0] = wrap_of(mode[0]);
    map->wrap[1] = wrap_of(mode[1]);

    if (name.data[0] == '*') { /* an embedded image */
        const unsigned long i = strtoul(name.data + 1, NULL, 10);
        if (i >= r->file->mNumTextures || r->file->mTextures[i]->mHeight != 0)
            return go_without(r, name.data, "is no embedded image in a file's format");
        const struct aiTexture *texture = r->file->mTextures[i];
        char label[300]; /* OpenImageIO chooses its reader by the extension */
        snprintf(label, sizeof label, "%.200s: texture %lu.%s", r->in->path, i,
                 strcmp(texture->achFormatHint, "jpeg") == 0 ? "jpg" : texture->achFormatHint);
        map->texture =
            rnd_texture_add(r->in->scene, label, texture->pcData, texture->mWidth, pixels, r->in->error);
        return map->texture >= 0;
    }
    char path[RND_PATH_SIZE];
    const bool found = (r->lines && rnd_find_file(r->library, name.data, false, path)) ||
                       rnd_find_file(r->in->directory, name.data, false, path);
    rnd_files_add(&r->in->scene->files, path);
    if (!found) return go_without(r, path, rnd_why_not_found(path));
    map->texture = rnd_texture_add(r->in->scene, path, NULL, 0, pixels, r->in->error);
    return map->texture >= 0;
}

/* --- colours and numbers --- */

static vec3s read_colour(struct reader *r, const char *key, vec3s otherwise)
{
    struct aiColor4D c;
    if (aiGetMaterialColor(r->from, key, 0, 0, &c) != aiReturn_SUCCESS) return otherwise;
    return (vec3s){{c.r, c.g, c.b}};
}

static float read_float(struct reader *r, const char *key, float otherwise)
{
    ai_real value;
    return aiGetMaterialFloatArray(r->from, key, 0, 0, &value, NULL) == aiReturn_SUCCESS ? value : otherwise;
}

/* Keys as text: assimp's macros expand to (key, type, index). */
#define KEY(macro)             KEY_(macro)
#define KEY_(key, type, index) key

/* False and a line if a value is out of range, or NaN. */
static bool check(struct reader *r, const char *key, float value, float low, float high)
{
    struct aiString name = {0};
    if (value >= low && value <= high) return true;
    aiGetMaterialString(r->from, AI_MATKEY_NAME, &name);
    return rnd_import_fail(r->in, "material \"%.60s\": %s is %g, expected %g to %g", name.data, key,
                           (double)value, (double)low, (double)high);
}

static bool check_colour(struct reader *r, const char *key, vec3s value, float high)
{
    return check(r, key, value.x, 0.0f, high) && check(r, key, value.y, 0.0f, high) &&
           check(r, key, value.z, 0.0f, high);
}

/* The filter of each of two surfaces that together filter light that passes through. */
static vec3s each_side(vec3s through)
{
    return (vec3s){{sqrtf(through.x), sqrtf(through.y), sqrtf(through.z)}};
}

/* -s and -o of maps: v grows upwards in MTL, and downwards here. */
static void transform_maps(const struct rnd_mtl_material *lines, struct rnd_material *to)
{
    static const enum rnd_map_use uses[RND_MTL_MAPS] = {[RND_MTL_KD] = RND_MAP_BASE,
                                                        [RND_MTL_KS] = RND_MAP_SPECULAR_COLOUR,
                                                        [RND_MTL_KE] = RND_MAP_EMISSION,
                                                        [RND_MTL_D] = RND_MAP_COVERAGE,
                                                        [RND_MTL_NORMAL] = RND_MAP_NORMAL};
    for (int k = 0; k < RND_MTL_MAPS; k++) {
        const float *s = lines->scale[k], *o = lines->offset[k];
        const float m[6] = {s[0], 0.0f, o[0], 0.0f, s[1], 1.0f - s[1] - o[1]};
        struct rnd_map *map = &to->map[uses[k]];
        memcpy(map->transform, m, sizeof m);
        map->has_transform = s[0] != 1.0f || s[1] != 1.0f || o[0] != 0.0f || o[1] != 0.0f;
    }
}

/* Pr and Pm of the PBR extension (Clara.io 2014): glTF's roughness and metalness. */
static void read_pbr(const struct rnd_mtl_material *lines, struct rnd_material *to)
{
    to->roughness = lines->pr >= 0.0f ? fminf(lines->pr, 1.0f) : 0.5f;
    to->metallic = lines->pm >= 0.0f ? fminf(lines->pm, 1.0f) : 0.0f;
    to->specular = 1.0f;
}

/* Read a material that is neither mirror nor glass, with or without a glossy coat. */
static bool read_opaque(struct reader *r, bool coat, vec3s ks, float ns, struct rnd_material *to)
{
    if (!read_map(r, aiTextureType_DIFFUSE, RND_MAP_BASE, RND_PIXELS_COLOUR, to)) return false;
    /* assimp assumes 0.6 if there is no Kd */
    if (r->lines && !r->lines->has_kd && to->map[RND_MAP_BASE].texture >= 0) to->base = glms_vec3_one();
    if (r->lines && (r->lines->pr >= 0.0f || r->lines->pm >= 0.0f)) return read_pbr(r->lines, to), true;
    if (!coat) return true;
    /* Phong's exponent to GGX alpha (Walter 2007, section 5.3), then to roughness */
    to->roughness = sqrtf(sqrtf(2.0f / (ns + 2.0f)));
    rnd_material_set_f0(to, glms_vec3_minv(ks, glms_vec3_one()));
    return read_map(r, aiTextureType_SPECULAR, RND_MAP_SPECULAR_COLOUR, RND_PIXELS_COLOUR, to);
}

/* illum 3, 5 and 8 are mirrors, 6 and 7 glass that refracts, 4 and 9 glass that does not, 2 a glossy coat
 * when Ks is not black: reflectance Ks at normal incidence, as wide as Phong's exponent Ns. */
bool rnd_mtl_material(struct rnd_import *in, const struct aiScene *file, const struct aiMaterial *from,
                      const struct rnd_mtl_file *mtl, struct rnd_material *to)
{
    struct reader r = {in, file, from, NULL, ""};
    struct aiString name = {0};
    int illum = 1;
    aiGetMaterialString(from, AI_MATKEY_NAME, &name);
    r.lines = rnd_mtl_file_find(mtl, name.data);
    if (r.lines) r.library = mtl->directory[r.lines->library];
    aiGetMaterialIntegerArray(from, AI_MATKEY_OBJ_ILLUM, &illum, NULL);
    const vec3s ks = read_colour(&r, KEY(AI_MATKEY_COLOR_SPECULAR), glms_vec3_zero()),
                tf = read_colour(&r, KEY(AI_MATKEY_COLOR_TRANSPARENT), glms_vec3_one()),
                kd = read_colour(&r, KEY(AI_MATKEY_COLOR_DIFFUSE), (vec3s){{0.8f, 0.8f, 0.8f}}),
                ke = read_colour(&r, KEY(AI_MATKEY_COLOR_EMISSIVE), glms_vec3_zero());
    const float ns = read_float(&r, KEY(AI_MATKEY_SHININESS), 0.0f),
                ni = read_float(&r, KEY(AI_MATKEY_REFRACTI), 1.5f),
                d = read_float(&r, KEY(AI_MATKEY_OPACITY), 1.0f);
    const bool glass = illum == 4 || illum == 6 || illum == 7 || illum == 9,
               mirror = illum == 3 || illum == 5 || illum == 8, shiny = glms_vec3_max(ks) > 0.0f;
    if (!check_colour(&r, "Kd", kd, 1e3f) || !check_colour(&r, "Ks", ks, 1e3f) ||
        !check_colour(&r, "Ke", ke, FLT_MAX) || !check(&r, "Ns", ns, 0.0f, FLT_MAX) ||
        !check(&r, "d", d, 0.0f, 1.0f) ||
        (glass && !(check_colour(&r, "Tf", tf, 1.0f) && check(&r, "Ni", ni, 1.0f, 1e3f))))
        return false;

    rnd_material_init(to);
    to->base = glms_vec3_minv(kd, glms_vec3_one());
    to->emission = ke;
    to->double_sided = true;
    to->metallic = 0.0f;
    to->specular = 0.0f;
    if (!read_map(&r, aiTextureType_EMISSIVE, RND_MAP_EMISSION, RND_PIXELS_COLOUR, to) ||
        !read_map(&r, aiTextureType_NORMALS, RND_MAP_NORMAL, RND_PIXELS_DATA, to))
        return false;
    if (glass) {
        to->base = each_side(tf);
        to->transmission = to->specular = 1.0f;
        to->thin = illum == 4 || illum == 9;
        to->roughness = 0.0f;
        to->ior = ni;
    } else if (mirror && shiny) {
        to->base = glms_vec3_minv(ks, glms_vec3_one());
        to->metallic = to->specular = 1.0f;
        to->roughness = 0.0f;
    } else if (!read_opaque(&r, illum == 2 && shiny && ns > 1.0f, ks, ns, to)) {
        return false;
    }
    if (!glass) { /* the d of glass says again that it is glass */
        if (!read_map(&r, aiTextureType_OPACITY, RND_MAP_COVERAGE, RND_PIXELS_DATA, to)) return false;
        to->alpha = d;
        if (d < 1.0f || to->map[RND_MAP_COVERAGE].texture >= 0) to->alpha_mode = RND_BLEND;
    }
    if (aiGetMaterialTextureCount(from, aiTextureType_HEIGHT) > 0)
        rnd_scene_unsupported(in->scene, "bump maps");
    if (aiGetMaterialTextureCount(from, aiTextureType_SHININESS) > 0)
        rnd_scene_unsupported(in->scene, "maps of Phong's exponent");
    if (r.lines) {
        transform_maps(r.lines, to);
        to->normal_scale = r.lines->bump;
        if (r.lines->has_pbr_maps) rnd_scene_unsupported(in->scene, "map_Pr and map_Pm");
    }
    rnd_material_set_kind(to);
    return true;
}
