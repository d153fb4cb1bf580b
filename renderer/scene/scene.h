/* The scene as the path tracer sees it: triangles in the world, materials, textures, lights, Embree's tree.
 */
#ifndef FOVEAD_RENDERER_SCENE_H
#define FOVEAD_RENDERER_SCENE_H

#include "renderer.h"
#include "scene/embree.h"
#include "scene/files.h"
#include "scene/lights.h"
#include "scene/corners.h"
#include "scene/texture.h"
#include "math/sphere.h"

#include <pthread.h>
#include <stdatomic.h>

/* --- materials --- */

/* Which of the integrator's stages serves a material: the cheapest that is right for it. */
enum rnd_material_kind {
    RND_DIFFUSE,     /* Lambert alone */
    RND_METAL_ROUGH, /* glTF 2.0 metallic-roughness: GGX over Lambert */
    RND_RICH,        /* all else that glTF has: transmission, volume, clearcoat, sheen, unlit, second uv */
};

/* What a texture of a material sets. */
enum rnd_map_use {
    RND_MAP_BASE,                /* sRGB; alpha is coverage */
    RND_MAP_METAL_ROUGH,         /* green roughness, blue metallic */
    RND_MAP_NORMAL,              /* tangent space */
    RND_MAP_EMISSION,            /* sRGB */
    RND_MAP_TRANSMISSION,        /* red */
    RND_MAP_SPECULAR,            /* alpha */
    RND_MAP_SPECULAR_COLOUR,     /* sRGB */
    RND_MAP_CLEARCOAT,           /* red */
    RND_MAP_CLEARCOAT_ROUGHNESS, /* green */
    RND_MAP_CLEARCOAT_NORMAL,
    RND_MAP_SHEEN_COLOUR,    /* sRGB */
    RND_MAP_SHEEN_ROUGHNESS, /* alpha */
    RND_MAP_COVERAGE, /* MTL's map_d: alpha if the image has it, else red; the base texture's alpha is then
                         ignored */
    RND_MAPS,
};

/* How a texture is looked up. KHR_texture_transform: (u, v) becomes (m0 u + m1 v + m2, m3 u + m4 v + m5). */
struct rnd_map {
    int texture; /* index, or -1: none, the factor is used alone */
    uint8_t uv_set;
    uint8_t wrap[2];    /* enum rnd_wrap along u and v */
    bool nearest;       /* texels are not interpolated */
    bool has_transform; /* else the transform is the identity */
    float transform[6];
};

/* A medium that light travels through: KHR_materials_volume and _ior. */
struct rnd_medium {
    float ior;
    uint32_t index;   /* number of its index of refraction among the scene's; 0 is air's */
    vec3s absorption; /* 1/m */
};

/* How many indices of refraction have tables of rough glass in each other. Rough glass in a medium of a
 * further index loses the light that its facets hide. */
enum { RND_GLASS_INDICES = 6 };

/* A material of glTF 2.0 with its extensions. Materials of other formats are mapped to it. */
struct rnd_material {
    enum rnd_material_kind kind;
    enum { RND_OPAQUE, RND_MASK, RND_BLEND } alpha_mode;
    vec3s base;
    float alpha,
        alpha_cutoff; /* coverage: factor of the base texture's alpha; below cutoff nothing is there */
    float metallic, roughness;
    bool glossiness_mapped; /* roughness is not final: it becomes 1 - (1 - roughness) times the mean alpha of
                               the specular colour's map */
    float ior;
    float f0;       /* reflectance of the non-metal at normal incidence: ((ior - 1) / (ior + 1))^2 specular */
    float specular; /* KHR_materials_specular: scales the reflectance of the non-metal */
    vec3s specular_colour;
    float transmission;
    bool thin;        /* transmits without bending: no KHR_materials_volume thickness */
    bool pane;        /* thin and smooth all over: light goes straight through */
    vec3s absorption; /* 1/m, inside: KHR_materials_volume */
    uint16_t medium;  /* the scene's medium that is inside; 0: light does not get inside */
    float clearcoat, clearcoat_roughness;
    vec3s sheen_colour;
    float sheen_roughness;
    float normal_scale, clearcoat_normal_scale;
    bool unlit;
    vec3s emission;    /* radiance, W sr-1 m-2 */
    bool double_sided; /* emits from both sides; light is scattered by both in any case */
    bool one_sided;    /* a camera does not see its back: glTF's back-face culling */
    struct rnd_map map[RND_MAPS];
    /* Of rough glass: the scene's tables of it in media of other indices of refraction, by rnd_medium.index.
     * NULL where light is not bent. */
    const struct rnd_glass *glass[RND_GLASS_INDICES];
};

/* Does a mesh of that material give light? */
static inline bool rnd_emits(const struct rnd_material *material)
{
    return rnd_luminance(material->emission.raw) > 0.0f && !material->unlit;
}

/* --- geometry --- */

struct rnd_mesh {
    uint32_t vertices, triangles;
    float *position; /* 3 per vertex, one float more for Embree's wide loads */
    float *normal;   /* 3 per vertex, or NULL: flat */
    float *uv[2];    /* 2 per vertex, or NULL: TEXCOORD_0 and _1 */
    float *colour;   /* linear RGBA, 4 per vertex, or NULL: COLOR_0, which multiplies base and alpha */
    float *tangent;  /* 4 per vertex: unit vector along u, and on which side of it v is (glTF 2.0
                        section 3.7.2.1), or NULL: they follow from texture coordinates */
    uint32_t (*index)[3];
    uint64_t first_corners; /* of its first triangle, in the scene's array */
    uint32_t material;
    uint32_t first_light; /* of its triangles among the scene's area lights, or UINT32_MAX */
    bool instanced;       /* in coordinates of its own, seen through instances alone; never a light */
};

/* A mesh that is shown at another place. */
struct rnd_instance {
    uint32_t mesh;
    float scale;              /* of lengths: the cube root of the factor by which volumes grow */
    float to_world[12];       /* 3 rows, 4 columns, column by column */
    float normal_to_world[9]; /* inverse transpose of its first three columns, column by column: normals keep
                                 their side, and lose their length */
    bool mirrors;             /* it reverses handedness: bitangents change sides */
};

/* --- scene --- */

/* Lines that a user should read, each with its line end and each once. After 20, one last line says that
 * there are more. */
struct rnd_warnings {
    char *text; /* NULL: none */
    size_t size;
    uint32_t lines;
};

struct rnd_scene {
    struct rnd_scene_info info;
    void *flat; /* what a reader has handed over; holds the meshes' arrays and the textures' files. NULL:
                   those are malloc'ed */
    size_t flat_bytes;
    struct rnd_image_program *image_program;
    uint32_t reader_mib, reader_seconds; /* as in rnd_scene_options; 0: the default */
    _Atomic int64_t tree_bytes;          /* that Embree has taken */
    atomic_bool trees_too_large;         /* it asked for more than reader_mib, and did not get it */
    const atomic_bool *cancel;           /* of the options; NULL once the scene is loaded */
    /* Where the scene's own coordinates begin, m: all but info is in these, since floats are too coarse far
     * from their origin. */
    double origin[3];
    char unsupported[1024];
    struct rnd_files files;                      /* while the file is imported; later info.files has them */
    struct rnd_warnings warnings, late_warnings; /* of the file; of textures that came later */
    bool one_sided;                              /* some of the materials are */
    bool textures_measured;                      /* the sizes of their files are known */
    uint32_t mesh_count, material_count, texture_count;
    struct rnd_mesh *mesh;
    struct rnd_material *material;
    struct rnd_texture *texture;
    uint32_t glass_count;
    struct rnd_glass **glass;    /* of materials, each once */
    uint32_t medium_count;       /* without air */
    struct rnd_medium *medium;   /* of materials, each once, from 1; 0 is air */
    struct rnd_corners *corners; /* of all triangles, mesh by mesh */
    uint32_t instance_count;
    struct rnd_instance *instance;
    struct rnd_lights lights;
    struct rnd_alpha *alpha; /* of the meshes that have coverage, for Embree's filters */
    RTCDevice device;
    RTCScene tree;
    bool clear_glass; /* as struct rnd_scene_options has it */
    /* Trees of some meshes, with the same ids as tree. NULL: there are no such meshes. */
    RTCScene clear_tree;  /* of meshes for which rnd_is_clear() is true */
    RTCScene border_tree; /* of meshes whose material has a medium */

    /* While textures are read: the materials with all their maps. Those in material lack the maps whose
     * textures are not read yet. */
    struct rnd_material *textured;
    pthread_t reader;
    bool reading;          /* the reader was started and has not been joined */
    atomic_bool read;      /* the reader is done */
    atomic_bool cancelled; /* nobody wants the textures any more */
};

/* Free the arrays of a mesh. */
void rnd_mesh_finish(struct rnd_mesh *mesh);

/* Add a name to rnd_scene_info.unsupported, if it is not there. */
void rnd_scene_unsupported(struct rnd_scene *scene, const char *name);

/* Add a warning. The format has no line end. */
void rnd_warn(struct rnd_warnings *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The mesh that Embree hit: geometry ids of the tree are meshes, and from mesh_count on instances. Returns
 * the instance that it was hit through, or NULL for a mesh in the world; then Embree's normal is in the
 * world too, else in the mesh's own coordinates. Only for hits: geom_id is not RTC_INVALID_GEOMETRY_ID. */
static inline const struct rnd_instance *rnd_resolve_hit(const struct rnd_scene *scene, uint32_t geom_id,
                                                         uint32_t inst_id, uint32_t *out_mesh)
{
    const struct rnd_instance *instance = NULL;
    if (inst_id != RTC_INVALID_GEOMETRY_ID) instance = &scene->instance[inst_id - scene->mesh_count];
    *out_mesh = instance ? instance->mesh : geom_id;
    return instance;
}

/* From the coordinates of an instance's mesh to the world. */
static inline vec3s rnd_instance_direction(const struct rnd_instance *instance, vec3s d)
{
    const float *m = instance->to_world;
    return (vec3s){{m[0] * d.x + m[3] * d.y + m[6] * d.z, m[1] * d.x + m[4] * d.y + m[7] * d.z,
                    m[2] * d.x + m[5] * d.y + m[8] * d.z}};
}

static inline vec3s rnd_instance_point(const struct rnd_instance *instance, vec3s p)
{
    const float *m = instance->to_world;
    return glms_vec3_add(rnd_instance_direction(instance, p), (vec3s){{m[9], m[10], m[11]}});
}

static inline vec3s rnd_vertex(const struct rnd_mesh *mesh, uint32_t i)
{
    return rnd_vec(mesh->position + 3 * (size_t)i);
}

/* Interpolate a vertex attribute of n floats at barycentric (u, v). */
static inline float rnd_interpolate(const float *attribute, int n, int c, const uint32_t index[3], float u,
                                    float v)
{
    return (1.0f - u - v) * attribute[(size_t)n * index[0] + c] + u * attribute[(size_t)n * index[1] + c] +
           v * attribute[(size_t)n * index[2] + c];
}

/* The texture coordinates of a map at barycentric (u, v) of a triangle; from (0, 0) if the mesh has none. */
static inline void rnd_map_uv(const struct rnd_map *map, const struct rnd_mesh *mesh, const uint32_t index[3],
                              float u, float v, float out[2])
{
    const float *uv = mesh->uv[map->uv_set];
    const float s = uv ? rnd_interpolate(uv, 2, 0, index, u, v) : 0.0f,
                t = uv ? rnd_interpolate(uv, 2, 1, index, u, v) : 0.0f;
    const float *m = map->transform;
    out[0] = map->has_transform ? m[0] * s + m[1] * t + m[2] : s;
    out[1] = map->has_transform ? m[3] * s + m[4] * t + m[5] : t;
}

#endif
