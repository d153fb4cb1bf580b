/* Emissive triangles: what they give, and drawing one. */
#include "light/area.h"
#include "material/coverage.h"

/* Texture of an emissive triangle at barycentric (u, v); bilinear in its finest level. */
static struct rnd_v3 emission_texture(const struct rnd_scene *scene, const struct rnd_area *area, float u,
                                      float v)
{
    const struct rnd_mesh *mesh = &scene->mesh[area->mesh];
    const struct rnd_map *map = &scene->material[mesh->material].map[RND_MAP_EMISSION];
    float place[2];
    rnd_map_uv(map, mesh, mesh->index[area->triangle], u, v, place);
    const struct rnd_texel t =
        rnd_texture_at(&scene->texture[map->texture], map->wrap, map->nearest, place[0], place[1]);
    return rnd_v3(t.r, t.g, t.b);
}

struct rnd_v3 rnd_area_emission(const struct rnd_scene *scene, const struct rnd_area *area, float u, float v)
{
    if (!(area->flags & RND_AREA_TEXTURED)) return area->emission;
    return rnd_v3_mul(area->emission, emission_texture(scene, area, u, v));
}

struct rnd_v3 rnd_area_gives(const struct rnd_scene *scene, const struct rnd_area *area, float s, float t)
{
    float u, v;
    rnd_area_place(area, s, t, &u, &v);
    const struct rnd_v3 emission = rnd_area_emission(scene, area, u, v);
    if (!(area->flags & RND_AREA_COVERED)) return emission;
    return rnd_v3_scale(emission, rnd_coverage(scene, area->mesh, area->triangle, u, v));
}

bool rnd_area_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                    const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_alias *alias = choice->emitters[RND_LIGHT_AREA];
    const uint32_t i = rnd_alias_draw(alias, u[1], u[0]);
    const struct rnd_area *area = &scene->lights.area[i];
    struct rnd_area_point drawn;
    out->part = scene->lights.emitters[RND_LIGHT_AREA].part[i];
    out->pdf = rnd_area_draw(area, alias->probability[i], point, u[2], u[3], &drawn);
    out->direction = drawn.direction;
    out->distance = drawn.distance;
    out->delta = false;
    if (!(out->pdf > 0.0f)) return false;
    out->radiance = rnd_area_gives(scene, area, drawn.s, drawn.t);
    return true;
}
