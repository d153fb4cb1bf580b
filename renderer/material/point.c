/* The surface at a point: what textures, vertex colours and normal maps make of a material there. */
#include "material/point.h"
#include "material/ggx.h"
#include "material/glass.h"

#include <string.h>

/* A point, and what its maps are looked up by. */
struct place {
    const struct rnd_scene *scene;
    const struct rnd_mesh *mesh;
    const struct rnd_material *material;
    const struct rnd_corners *corners;
    const struct rnd_point *point;
    const struct rnd_facing *facing;
    const struct rnd_filter *filter;
};

static const struct rnd_corners *corners_of(const struct rnd_scene *scene, const struct rnd_point *point)
{
    return &scene->corners[scene->mesh[point->mesh].first_corners + point->triangle];
}

/* --- what the packed corners do not hold: the second set of texture coordinates, tangents of a turned map
 * --- */

/* Texture coordinates of the triangle's corners. */
struct uvs {
    float uv[3][2];
    float lod; /* as in rnd_corners */
};

/* How texture coordinates run over the triangle, in the mesh's coordinates. */
static struct rnd_uv_frame uv_frame(const struct place *at, const float uv[3][2])
{
    const uint32_t *index = at->mesh->index[at->point->triangle];
    struct rnd_v3 p[3];
    for (int k = 0; k < 3; k++) p[k] = rnd_to_v3(rnd_vertex(at->mesh, index[k]));
    return rnd_uv_frame(uv, rnd_v3_sub(p[1], p[0]), rnd_v3_sub(p[2], p[0]));
}

/* In the set of texture coordinates that a map has; a mesh without that set has (0, 0) everywhere. */
static struct uvs uvs_of(const struct place *at, const struct rnd_map *map)
{
    const uint32_t *index = at->mesh->index[at->point->triangle];
    const float *uv = at->mesh->uv[1];
    struct uvs out = {.lod = RND_NO_EXTENT};
    if (map->uv_set == 0) {
        memcpy(out.uv, at->corners->uv, sizeof out.uv);
        out.lod = at->corners->lod;
        return out;
    }
    if (!uv) return out;
    for (int k = 0; k < 3; k++) memcpy(out.uv[k], uv + 2 * (size_t)index[k], sizeof out.uv[k]);
    out.lod = uv_frame(at, (const float(*)[2])out.uv).lod;
    return out;
}

static struct rnd_tangent tangent_of(const struct place *at, const struct rnd_map *map)
{
    static const float corner[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    const bool by_corners = at->mesh->tangent || (map->uv_set == 0 && !map->has_transform);
    if (by_corners && rnd_has_tangents(at->mesh, at->corners))
        return rnd_tangent_at(at->corners->tangent, at->point->u, at->point->v);
    const struct uvs own = uvs_of(at, map);
    float uv[3][2];
    for (int k = 0; k < 3; k++) rnd_map_place(map, own.uv, corner[k][0], corner[k][1], &uv[k][0], &uv[k][1]);
    const struct rnd_uv_frame frame = uv_frame(at, (const float(*)[2])uv);
    return (struct rnd_tangent){frame.along, frame.mirrored ? -1.0f : 1.0f};
}

/* --- maps --- */

/* The texture of a map at the point; white if the factor stands alone. */
static struct rnd_texel look(const struct place *at, enum rnd_map_use use)
{
    const struct rnd_map *map = &at->material->map[use];
    if (map->texture < 0) return (struct rnd_texel){1.0f, 1.0f, 1.0f, 1.0f};
    const struct rnd_texture *texture = &at->scene->texture[map->texture];
    const struct uvs uvs = uvs_of(at, map);
    const float cosine = fabsf(rnd_v3_dot(at->facing->direction, at->facing->shading)),
                level = rnd_level_at(rnd_map_lod(map, uvs.lod) + texture->log2_size, at->filter->footprint,
                                     cosine, at->filter->finer);
    float x, y;
    rnd_map_place(map, uvs.uv, at->point->u, at->point->v, &x, &y);
    return rnd_texture_texel(texture, rnd_map_texel(map, texture, x, y, level, at->filter->pick));
}

static vec3s map_rgb(const struct place *at, enum rnd_map_use use)
{
    const struct rnd_texel t = look(at, use);
    return (vec3s){{t.r, t.g, t.b}};
}

/* The shading normal as a normal map bends it. */
static vec3s map_normal(const struct place *at, enum rnd_map_use use, float scale)
{
    const struct rnd_map *map = &at->material->map[use];
    if (map->texture < 0) return rnd_from_v3(at->facing->shading);
    struct rnd_tangent tangent = tangent_of(at, map);
    if (at->point->instance) tangent = rnd_tangent_to_world(at->point->instance, tangent);
    return rnd_from_v3(rnd_bend_normal(at->facing, tangent, scale, look(at, use)));
}

/* --- the surface --- */

static void layers_at(const struct place *at, struct rnd_layers *l)
{
    const struct rnd_material *m = at->material;
    const float r = (m->ior - 1.0f) / (m->ior + 1.0f);
    l->specular = m->specular * look(at, RND_MAP_SPECULAR).a;
    l->f0 = glms_vec3_scale(glms_vec3_mul(m->specular_colour, map_rgb(at, RND_MAP_SPECULAR_COLOUR)), r * r);
    l->f0 = glms_vec3_scale(glms_vec3_minv(l->f0, glms_vec3_one()), l->specular);
    l->transmission = m->transmission * map_rgb(at, RND_MAP_TRANSMISSION).x;
    l->coat = m->clearcoat * map_rgb(at, RND_MAP_CLEARCOAT).x;
    l->coat_alpha = rnd_alpha(m->clearcoat_roughness * map_rgb(at, RND_MAP_CLEARCOAT_ROUGHNESS).y);
    l->coat_normal = map_normal(at, RND_MAP_CLEARCOAT_NORMAL, m->clearcoat_normal_scale);
    l->sheen = glms_vec3_mul(m->sheen_colour, map_rgb(at, RND_MAP_SHEEN_COLOUR));
    l->sheen_roughness = m->sheen_roughness * look(at, RND_MAP_SHEEN_ROUGHNESS).a;
}

void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_point *point,
                    const struct rnd_facing *facing, const struct rnd_filter *filter, struct rnd_surface *out)
{
    const struct rnd_mesh *mesh = &scene->mesh[point->mesh];
    const struct rnd_material *material = &scene->material[mesh->material];
    const struct place at = {scene, mesh, material, corners_of(scene, point), point, facing, filter};
    out->material = material;
    out->position = rnd_from_v3(point->position);
    out->front = facing->side > 0.0f;
    out->geometric = rnd_from_v3(facing->geometric);
    out->shading = map_normal(&at, RND_MAP_NORMAL, material->normal_scale);
    out->base = glms_vec3_mul(material->base, map_rgb(&at, RND_MAP_BASE));
    if (mesh->colour)
        out->base = glms_vec3_mul(out->base, rnd_from_v3(rnd_vertex_colour(at.corners, point->u, point->v)));
    const struct rnd_texel mr = look(&at, RND_MAP_METAL_ROUGH);
    out->metallic = material->metallic * mr.b;
    out->alpha = rnd_alpha(material->roughness * mr.g);
    layers_at(&at, &out->layers);
    out->pane = rnd_is_pane(mesh, material);
    out->between = rnd_interface_in_air(material, out->front);
}

struct rnd_facing rnd_facing_at(const struct rnd_scene *scene, const struct rnd_point *point,
                                struct rnd_v3 normal, struct rnd_v3 direction)
{
    const uint32_t *code = corners_of(scene, point)->normal;
    struct rnd_v3 smooth = rnd_smooth_normal(code[0], code[1], code[2], point->u, point->v);
    if (point->instance) {
        normal = rnd_normal_to_world(point->instance, normal);
        smooth = rnd_normal_to_world(point->instance, smooth);
    }
    return rnd_face(normal, smooth, direction);
}
