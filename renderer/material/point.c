/* The surface at a hit: what textures, vertex colours and normal maps make of a material at a point. */
#include "material/point.h"
#include "material/ggx.h"
#include "material/glass.h"

#include <string.h>

/* One float next to another, step representable numbers away. */
static float step_float(float x, int step)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits += x < 0.0f ? -step : step;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

vec3s rnd_leave(const struct rnd_surface *surface, vec3s direction)
{
    const float side = glms_vec3_dot(direction, surface->geometric) >= 0.0f ? 1.0f : -1.0f;
    vec3s out;
    for (int c = 0; c < 3; c++) {
        const float p = surface->position.raw[c], n = side * surface->geometric.raw[c];
        out.raw[c] = fabsf(p) < 1.0f / 32.0f ? p + n / 65536.0f : step_float(p, (int)(256.0f * n));
    }
    return out;
}

/* --- maps --- */

/* A hit and what maps need of it. */
struct place {
    const struct rnd_scene *scene;
    const struct rnd_mesh *mesh;
    const struct rnd_material *material;
    const uint32_t *index;
    const struct rnd_instance *instance;
    float u, v;
};

/* The texture of a map at the point; white if the factor stands alone. */
static struct rnd_texel look(const struct place *at, enum rnd_map_use use)
{
    const struct rnd_map *map = &at->material->map[use];
    float uv[2];
    if (map->texture < 0 || !at->mesh->uv[map->uv_set]) return (struct rnd_texel){1.0f, 1.0f, 1.0f, 1.0f};
    rnd_map_uv(map, at->mesh, at->index, at->u, at->v, uv);
    return rnd_texture_at(&at->scene->texture[map->texture], map->wrap, map->nearest, uv[0], uv[1]);
}

static vec3s map_rgb(const struct place *at, enum rnd_map_use use)
{
    const struct rnd_texel t = look(at, use);
    return (vec3s){{t.r, t.g, t.b}};
}

/* --- normals --- */

/* The file's tangent at the point, and the bitangent's side of it. */
static vec3s own_tangent(const struct place *at, float *out_side)
{
    const float *tangent = at->mesh->tangent;
    vec3s along;
    for (int c = 0; c < 3; c++) along.raw[c] = rnd_interpolate(tangent, 4, c, at->index, at->u, at->v);
    *out_side = tangent[4 * (size_t)at->index[0] + 3] > 0.0f ? 1.0f : -1.0f;
    if (!at->instance) return along;
    if (at->instance->mirrors) *out_side = -*out_side;
    return rnd_instance_direction(at->instance, along);
}

/* The directions along which a map's u and v grow over the triangle. */
static void along_map(const struct place *at, const struct rnd_map *map, vec3s *out_u, vec3s *out_v)
{
    static const float place[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    float corner[3][2];
    for (int k = 0; k < 3; k++) rnd_map_uv(map, at->mesh, at->index, place[k][0], place[k][1], corner[k]);
    vec3s p[3];
    for (int k = 0; k < 3; k++) {
        p[k] = rnd_vertex(at->mesh, at->index[k]);
        if (at->instance) p[k] = rnd_instance_point(at->instance, p[k]);
    }
    const vec3s e1 = glms_vec3_sub(p[1], p[0]), e2 = glms_vec3_sub(p[2], p[0]);
    const float u1 = corner[1][0] - corner[0][0], v1 = corner[1][1] - corner[0][1],
                u2 = corner[2][0] - corner[0][0], v2 = corner[2][1] - corner[0][1];
    const float turn = u1 * v2 - u2 * v1 < 0.0f ? -1.0f : 1.0f;
    *out_u = glms_vec3_scale(glms_vec3_sub(glms_vec3_scale(e1, v2), glms_vec3_scale(e2, v1)), turn);
    *out_v = glms_vec3_scale(glms_vec3_sub(glms_vec3_scale(e2, u1), glms_vec3_scale(e1, u2)), turn);
}

/* The outside normal n bent by a normal map. glTF's texture space has u to the right, v down the image, and
 * green up it, so that the bitangent runs against v. */
static vec3s map_normal(const struct place *at, enum rnd_map_use use, float scale, vec3s n)
{
    const struct rnd_map *map = &at->material->map[use];
    vec3s along_u, along_v = glms_vec3_zero();
    float side = 0.0f;
    if (map->texture < 0 || !at->mesh->uv[map->uv_set]) return n;
    if (at->mesh->tangent)
        along_u = own_tangent(at, &side);
    else
        along_map(at, map, &along_u, &along_v);
    vec3s x = glms_vec3_sub(along_u, glms_vec3_scale(n, glms_vec3_dot(n, along_u)));
    const float length = glms_vec3_norm(x);
    if (!(length > 0.0f)) return n; /* texture coordinates that span nothing */
    x = glms_vec3_scale(x, 1.0f / length);
    vec3s y = glms_vec3_cross(n, x);
    if (side == 0.0f) side = glms_vec3_dot(y, along_v) > 0.0f ? -1.0f : 1.0f;
    y = glms_vec3_scale(y, side);

    const vec3s t = glms_vec3_subs(glms_vec3_scale(map_rgb(at, use), 2.0f), 1.0f);
    vec3s out = glms_vec3_scale(n, t.z);
    out = glms_vec3_muladds(x, scale * t.x, out);
    out = glms_vec3_muladds(y, scale * t.y, out);
    const float norm = glms_vec3_norm(out);
    return norm > 0.0f ? glms_vec3_scale(out, 1.0f / norm) : n;
}

/* A normal of the outside turned to the side of the ray. One that the ray sees from behind is bent until it
 * is seen; one below the surface is not taken. */
static vec3s facing(vec3s n, const struct rnd_surface *s, vec3s direction)
{
    const float seen = 1e-2f;
    if (!s->front) n = glms_vec3_negate(n);
    const float c = -glms_vec3_dot(n, direction);
    if (c < seen) n = glms_vec3_normalize(glms_vec3_muladds(direction, c - seen, n));
    return glms_vec3_dot(n, s->geometric) > 0.0f ? n : s->geometric;
}

/* --- the surface --- */

static void layers_at(const struct place *at, vec3s smooth, vec3s direction, struct rnd_surface *out)
{
    const struct rnd_material *m = at->material;
    struct rnd_layers *l = &out->layers;
    const float r = (m->ior - 1.0f) / (m->ior + 1.0f);
    l->specular = m->specular * look(at, RND_MAP_SPECULAR).a;
    l->f0 = glms_vec3_scale(glms_vec3_mul(m->specular_colour, map_rgb(at, RND_MAP_SPECULAR_COLOUR)), r * r);
    l->f0 = glms_vec3_scale(glms_vec3_minv(l->f0, glms_vec3_one()), l->specular);
    l->transmission = m->transmission * map_rgb(at, RND_MAP_TRANSMISSION).x;
    l->coat = m->clearcoat * map_rgb(at, RND_MAP_CLEARCOAT).x;
    l->coat_alpha = rnd_alpha(m->clearcoat_roughness * map_rgb(at, RND_MAP_CLEARCOAT_ROUGHNESS).y);
    l->coat_normal =
        facing(map_normal(at, RND_MAP_CLEARCOAT_NORMAL, m->clearcoat_normal_scale, smooth), out, direction);
    l->sheen = glms_vec3_mul(m->sheen_colour, map_rgb(at, RND_MAP_SHEEN_COLOUR));
    l->sheen_roughness = m->sheen_roughness * look(at, RND_MAP_SHEEN_ROUGHNESS).a;
}

void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_hit *hit, vec3s direction,
                    struct rnd_surface *out)
{
    const struct rnd_mesh *mesh = &scene->mesh[hit->mesh];
    const struct rnd_material *material = &scene->material[mesh->material];
    const uint32_t *index = mesh->index[hit->triangle];
    const struct place at = {scene, mesh, material, index, hit->instance, hit->u, hit->v};

    out->material = material;
    for (int c = 0; c < 3; c++)
        out->position.raw[c] = rnd_interpolate(mesh->position, 3, c, index, hit->u, hit->v);
    if (hit->instance) out->position = rnd_instance_point(hit->instance, out->position);
    const vec3s outside =
        glms_vec3_normalize(hit->instance ? rnd_instance_normal(hit->instance, hit->normal) : hit->normal);
    out->front = glms_vec3_dot(outside, direction) < 0.0f;
    out->geometric = out->front ? outside : glms_vec3_negate(outside);
    vec3s smooth = outside;
    if (mesh->normal) {
        vec3s n;
        for (int c = 0; c < 3; c++) n.raw[c] = rnd_interpolate(mesh->normal, 3, c, index, hit->u, hit->v);
        n = glms_vec3_normalize(hit->instance ? rnd_instance_normal(hit->instance, n) : n);
        const float side = out->front ? 1.0f : -1.0f;
        if (side * glms_vec3_dot(n, direction) < 0.0f && glms_vec3_dot(n, outside) > 0.0f) smooth = n;
    }
    out->shading = out->front ? smooth : glms_vec3_negate(smooth);
    if (material->map[RND_MAP_NORMAL].texture >= 0)
        out->shading =
            facing(map_normal(&at, RND_MAP_NORMAL, material->normal_scale, smooth), out, direction);

    out->base = material->base;
    out->metallic = material->metallic;
    const float roughness = material->roughness;
    if (mesh->colour)
        for (int c = 0; c < 3; c++)
            out->base.raw[c] *= rnd_interpolate(mesh->colour, 4, c, index, hit->u, hit->v);
    out->base = glms_vec3_mul(out->base, map_rgb(&at, RND_MAP_BASE));
    const struct rnd_texel mr = look(&at, RND_MAP_METAL_ROUGH);
    out->metallic *= mr.b;
    out->alpha = rnd_alpha(roughness * mr.g);
    if (material->kind != RND_RICH) return;
    layers_at(&at, smooth, direction, out);
    out->pane = rnd_is_pane(mesh, material);
    out->between = rnd_interface_in_air(material, out->front);
}
