/* From hits to surfaces: which mesh, which material, the normals, the textures. */
#include "path/surface.h"
#include "path/emission.h"
#include "material/ggx.h"
#include "material/point.h"
#include "material/shading.h"

/* --- order --- */

/* Put hit k = order[j] of paths 0 at place j of paths 1 and of the surfaces, and move the path's origin to
 * the point that was hit. */
static void gather(struct rnd_tracer *tracer, const uint32_t *order, uint32_t count)
{
    const struct rnd_paths *from = &tracer->paths[0];
    const struct rnd_hits *hits = &tracer->hits;
    struct rnd_paths *to = &tracer->paths[1];
    struct rnd_surfaces *s = &tracer->surfaces;
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const uint32_t i = order[j];
        const float t = hits->distance[i];
        s->distance[j] = t;
        to->origin.x[j] = from->origin.x[i] + t * from->direction.x[i];
        to->origin.y[j] = from->origin.y[i] + t * from->direction.y[i];
        to->origin.z[j] = from->origin.z[i] + t * from->direction.z[i];
        to->direction.x[j] = from->direction.x[i];
        to->direction.y[j] = from->direction.y[i];
        to->direction.z[j] = from->direction.z[i];
        s->footprint[j] = to->width[j] = from->width[i] + t * tracer->spread;
    }
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const uint32_t i = order[j];
        to->throughput.x[j] = from->throughput.x[i];
        to->throughput.y[j] = from->throughput.y[i];
        to->throughput.z[j] = from->throughput.z[i];
        to->first[j] = from->first[i];
        to->pdf[j] = from->pdf[i];
        to->seed[j] = from->seed[i];
        to->index[j] = from->index[i];
        to->id[j] = from->id[i];
    }
    for (uint32_t j = 0; tracer->scene->clear_tree && j < count; j++)
        to->stood_for[j] = from->stood_for[order[j]];
    for (uint32_t j = 0; rnd_has_media(tracer) && j < count; j++) {
        const rnd_media media = to->media[j] = s->behind[j] = from->media[order[j]];
        if (media)
            rnd_put(&to->throughput, j,
                    rnd_v3_mul(rnd_get(&to->throughput, j),
                               rnd_media_transmittance(tracer->scene, media, s->distance[j])));
    }
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const uint32_t i = order[j];
        s->u[j] = hits->u[i];
        s->v[j] = hits->v[i];
        s->geometric.x[j] = hits->normal.x[i];
        s->geometric.y[j] = hits->normal.y[i];
        s->geometric.z[j] = hits->normal.z[i];
        s->triangle[j] = hits->primitive[i];
    }
}

/* --- geometry --- */

/* Unit normals on the side that the ray came from. The shading normal is interpolated. */
static void face(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_corners *all = tracer->scene->corners;
    const struct rnd_paths *paths = &tracer->paths[1];
    struct rnd_surfaces *s = &tracer->surfaces;
    uint32_t(*corner)[RND_WAVE] = tracer->scratch.surface.corner;
    for (uint32_t j = 0; j < count; j++) {
        const struct rnd_corners *corners = &all[s->corners[j]];
        corner[0][j] = corners->normal[0];
        corner[1][j] = corners->normal[1];
        corner[2][j] = corners->normal[2];
    }
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const struct rnd_v3 smooth =
            rnd_smooth_normal(corner[0][j], corner[1][j], corner[2][j], s->u[j], s->v[j]);
        const struct rnd_facing facing =
            rnd_face(rnd_get(&s->geometric, j), smooth, rnd_get(&paths->direction, j));
        rnd_put(&s->geometric, j, facing.geometric);
        rnd_put(&s->normal, j, facing.shading);
        s->front[j] = facing.side > 0.0f ? 1u : 0u;
    }
}

/* For hits on instances: bring normals from the mesh's coordinates to the world, and footprints from metres
 * in the world to metres of the mesh. */
static void face_instances(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_scene *scene = tracer->scene;
    struct rnd_surfaces *s = &tracer->surfaces;
    for (uint32_t j = 0; j < count; j++) {
        if (s->instance[j] == RTC_INVALID_GEOMETRY_ID) continue;
        const struct rnd_instance *instance = &scene->instance[s->instance[j] - scene->mesh_count];
        const uint32_t *code = scene->corners[s->corners[j]].normal;
        const struct rnd_v3 smooth = rnd_smooth_normal(code[0], code[1], code[2], s->u[j], s->v[j]),
                            own = rnd_v3_scale(rnd_get(&s->geometric, j), s->front[j] ? 1.0f : -1.0f),
                            outside = rnd_normal_to_world(instance, own),
                            around = rnd_normal_to_world(instance, smooth);
        const struct rnd_facing facing = rnd_face(outside, around, rnd_get(&tracer->paths[1].direction, j));
        rnd_put(&s->geometric, j, facing.geometric);
        rnd_put(&s->normal, j, facing.shading);
        s->front[j] = facing.side > 0.0f;
        s->footprint[j] /= instance->scale;
    }
}

/* The normals of a point, as face() stored them. */
static struct rnd_facing facing_at(const struct rnd_tracer *tracer, uint32_t j)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    return (struct rnd_facing){rnd_get(&tracer->paths[1].direction, j), rnd_get(&s->geometric, j),
                               rnd_get(&s->normal, j), s->front[j] ? 1.0f : -1.0f};
}

/* --- materials --- */

/* By how many levels textures are finer in this step than the path's cone asks for. */
static float finer(const struct rnd_tracer *tracer)
{
    return tracer->depth > 0 ? RND_INDIRECT_FINER : 0.0f;
}

/* Note that a map is to be looked up for a point. */
static void note(struct rnd_tracer *tracer, const struct rnd_map *map, uint32_t j, uint32_t *lookups)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_texture *texture = &tracer->scene->texture[map->texture];
    const struct rnd_corners *corners = &tracer->scene->corners[s->corners[j]];
    const uint32_t k = (*lookups)++;
    tracer->lookup[k] = (struct rnd_lookup){.texture = texture, .map = map, .point = j};
    rnd_map_place(map, corners->uv, s->u[j], s->v[j], &tracer->lookup_x[k], &tracer->lookup_y[k]);
    tracer->lookup_level[k] = rnd_map_lod(map, corners->lod) + texture->log2_size;
}

/* Choose the texels of all look-ups by the paths' cones, each with its own random neighbour of four. Texels
 * are prefetched here, and read later. */
static void ask(struct rnd_tracer *tracer, uint32_t lookups)
{
    const struct rnd_paths *paths = &tracer->paths[1];
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_lookup *lookup = tracer->lookup;
    float *level = tracer->lookup_level, *r = tracer->number[0], *t = tracer->number[1];
    const float by = finer(tracer);
    const uint32_t which = (uint32_t)tracer->depth;
#pragma GCC ivdep
    for (size_t k = 0; k < lookups; k++) {
        const uint32_t j = lookup[k].point;
        const float cosine = fabsf(rnd_v3_dot(rnd_get(&paths->direction, j), rnd_get(&s->normal, j)));
        level[k] = rnd_level_at(level[k], s->footprint[j], cosine, by);
        rnd_dither(paths->seed[j], paths->index[j], which, &r[k], &t[k]);
    }
    for (uint32_t k = 0; k < lookups; k++) {
        const struct rnd_texture *texture = lookup[k].texture;
        const float pick[2] = {r[k], t[k]};
        const size_t texel =
            rnd_map_texel(lookup[k].map, texture, tracer->lookup_x[k], tracer->lookup_y[k], level[k], pick);
        lookup[k].texel = texel;
        __builtin_prefetch(texture->bytes ? (const void *)(texture->bytes + 4 * texel)
                                          : (const void *)(texture->floats + 4 * texel));
    }
}

/* Factors and base colours of points begin to end. */
static void base_colours(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_scene *scene = tracer->scene;
    struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_lookup *lookup = tracer->lookup;
    uint32_t lookups = 0;
    for (uint32_t j = begin; j < end; j++) {
        const struct rnd_material *material = &scene->material[s->material[j]];
        struct rnd_v3 base = {material->base.x, material->base.y, material->base.z};
        if (scene->mesh[s->mesh[j]].colour)
            base = rnd_v3_mul(base, rnd_vertex_colour(&scene->corners[s->corners[j]], s->u[j], s->v[j]));
        rnd_put(&s->base, j, base);
        if (material->map[RND_MAP_BASE].texture >= 0) note(tracer, &material->map[RND_MAP_BASE], j, &lookups);
    }
    ask(tracer, lookups);
    for (uint32_t k = 0; k < lookups; k++) {
        const struct rnd_texel t = rnd_texture_texel(lookup[k].texture, lookup[k].texel);
        const uint32_t j = lookup[k].point;
        s->base.x[j] *= t.r;
        s->base.y[j] *= t.g;
        s->base.z[j] *= t.b;
    }
}

/* Metalness, roughness and reflectance. */
static void reflectances(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_scene *scene = tracer->scene;
    struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_lookup *lookup = tracer->lookup;
    uint32_t lookups = 0;
    for (uint32_t j = begin; j < end; j++) {
        const struct rnd_material *material = &scene->material[s->material[j]];
        s->metallic[j] = material->metallic;
        s->alpha[j] = material->roughness; /* squared below */
        s->f0[j] = material->f0;
        s->f90[j] = material->specular;
        const struct rnd_map *map = &material->map[RND_MAP_METAL_ROUGH];
        if (map->texture >= 0) note(tracer, map, j, &lookups);
    }
    ask(tracer, lookups);
    for (uint32_t k = 0; k < lookups; k++) {
        const struct rnd_texel t = rnd_texture_texel(lookup[k].texture, lookup[k].texel);
        s->alpha[lookup[k].point] *= t.g;
        s->metallic[lookup[k].point] *= t.b;
    }
    for (uint32_t j = begin; j < end; j++) s->alpha[j] = rnd_alpha(s->alpha[j]);
}

/* Bend the normals by normal maps. */
static void bend_normals(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_scene *scene = tracer->scene;
    struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_lookup *lookup = tracer->lookup;
    uint32_t lookups = 0;
    for (uint32_t j = begin; j < end; j++) {
        const struct rnd_map *map = &scene->material[s->material[j]].map[RND_MAP_NORMAL];
        if (map->texture >= 0 && rnd_has_tangents(&scene->mesh[s->mesh[j]], &scene->corners[s->corners[j]]))
            note(tracer, map, j, &lookups);
    }
    ask(tracer, lookups);
    for (uint32_t k = 0; k < lookups; k++) {
        const uint32_t j = lookup[k].point;
        const struct rnd_texel t = rnd_texture_texel(lookup[k].texture, lookup[k].texel);
        struct rnd_tangent tangent = rnd_tangent_at(scene->corners[s->corners[j]].tangent, s->u[j], s->v[j]);
        if (s->instance[j] != RTC_INVALID_GEOMETRY_ID)
            tangent = rnd_tangent_to_world(&scene->instance[s->instance[j] - scene->mesh_count], tangent);
        const struct rnd_facing facing = facing_at(tracer, j);
        rnd_put(&s->normal, j,
                rnd_bend_normal(&facing, tangent, scene->material[s->material[j]].normal_scale, t));
    }
}

/* --- rich materials --- */

/* Pass the border of a volume. */
static void pass_border(struct rnd_tracer *tracer, uint32_t j, struct rnd_surface *surface)
{
    const struct rnd_hits *hits = &tracer->hits;
    struct rnd_surfaces *s = &tracer->surfaces;
    const uint32_t i = tracer->scratch.surface.order[j];
    const struct rnd_v3 at = rnd_get(&tracer->paths[1].origin, j);
    const struct rnd_border border = {.at = at,
                                      .normal = rnd_get(&s->geometric, j),
                                      .off = rnd_offset(at, s->distance[j]),
                                      .geometry = hits->geometry[i],
                                      .primitive = hits->primitive[i],
                                      .instance = hits->instance[i]};
    s->behind[j] = rnd_media_pass(tracer->scene, tracer->paths[1].media[j], &border, surface);
}

/* All of a rich material's point at once. A surface that is unlit emits its base colour. */
static void rich_points(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_scene *scene = tracer->scene;
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_paths *paths = &tracer->paths[1];
    for (uint32_t j = begin; j < end; j++) {
        struct rnd_point point = {.mesh = s->mesh[j],
                                  .triangle = s->triangle[j],
                                  .u = s->u[j],
                                  .v = s->v[j],
                                  .position = rnd_get(&paths->origin, j)};
        if (s->instance[j] != RTC_INVALID_GEOMETRY_ID)
            point.instance = &scene->instance[s->instance[j] - scene->mesh_count];
        struct rnd_filter filter = {.footprint = s->footprint[j], .finer = finer(tracer)};
        rnd_dither(paths->seed[j], paths->index[j], (uint32_t)tracer->depth, &filter.pick[0],
                   &filter.pick[1]);
        const struct rnd_facing facing = facing_at(tracer, j);
        struct rnd_surface *surface = &tracer->rich[j - begin];
        rnd_surface_at(scene, &point, &facing, &filter, surface);
        if (surface->material->medium) pass_border(tracer, j, surface);
        if (surface->material->unlit)
            rnd_add_radiance(tracer, paths->id[j],
                             rnd_v3_mul(rnd_get(&paths->throughput, j), rnd_to_v3(surface->base)));
    }
}

/* --- stages --- */

uint32_t ISA(rnd_surface)(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_scene *scene = tracer->scene;
    const struct rnd_hits *hits = &tracer->hits;
    struct rnd_surfaces *s = &tracer->surfaces;
    uint32_t number[RND_RICH + 1] = {0}, missed = 0;
    uint32_t(*list)[RND_WAVE] = tracer->list, *miss = tracer->list[RND_RICH + 1];
    for (uint32_t i = 0; i < count; i++) {
        if (hits->geometry[i] == RTC_INVALID_GEOMETRY_ID) {
            miss[missed++] = i;
            continue;
        }
        uint32_t m;
        rnd_resolve_hit(scene, hits->geometry[i], hits->instance[i], &m);
        const struct rnd_mesh *mesh = &scene->mesh[m];
        const enum rnd_material_kind kind = scene->material[mesh->material].kind;
        __builtin_prefetch(&scene->corners[mesh->first_corners + hits->primitive[i]]);
        list[kind][number[kind]++] = i;
    }
    uint32_t *order = tracer->scratch.surface.order, hit = 0;
    for (int kind = 0; kind <= RND_RICH; kind++) {
        for (uint32_t k = 0; k < number[kind]; k++) {
            const uint32_t i = list[kind][k];
            rnd_resolve_hit(scene, hits->geometry[i], hits->instance[i], &s->mesh[hit]);
            const struct rnd_mesh *mesh = &scene->mesh[s->mesh[hit]];
            s->instance[hit] = hits->instance[i];
            s->material[hit] = mesh->material;
            s->corners[hit] = (uint32_t)mesh->first_corners + hits->primitive[i];
            order[hit++] = i;
        }
        s->end[kind] = hit;
    }
    ISA(rnd_sky)(tracer, miss, missed);
    gather(tracer, order, hit);
    face(tracer, hit);
    if (scene->instance_count > 0) face_instances(tracer, hit);
    if (!rnd_is_last(tracer)) { /* paths end there, so what their surfaces reflect is not needed */
        base_colours(tracer, 0, s->end[RND_METAL_ROUGH]);
        reflectances(tracer, s->end[RND_DIFFUSE], s->end[RND_METAL_ROUGH]);
        bend_normals(tracer, s->end[RND_DIFFUSE], s->end[RND_METAL_ROUGH]);
    }
    rich_points(tracer, s->end[RND_METAL_ROUGH], hit);
    return hit;
}
