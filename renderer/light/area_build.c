/* Emissive triangles: how often each is drawn. A triangle whose texture or coverage makes its light uneven is
 * divided, the more the brighter its parts are, so that a bright spot is drawn as often as it should be. */
#include "light/area_build.h"
#include "light/area.h"
#include "light/emitters.h"
#include "light/pyramid.h"
#include "material/coverage.h"

#include <stdlib.h>

/* Limits: of divisions in a scene, each of which makes four areas of one; and of halvings of a triangle's
 * sides. */
enum { DIVISIONS = 1 << 14, HALVINGS = 13 };
/* A division is made if it may lower the weight of all areas by this share; less is not worth its memory. */
#define LEAST_WON 1e-4
/* A division is kept if it has lowered the weight of the divided area by this share. Points spread more
 * evenly over one area than over many, so a division alone adds noise. */
#define LEAST_KEPT 0.03f

/* What makes the light of a mesh uneven. */
struct pattern {
    struct rnd_pyramid *emission, *coverage; /* the builder's; NULL: there is no such texture */
    const struct rnd_map *coverage_map;
    float brightness; /* luminance without the texture */
    float alpha, cutoff;
    bool covered, masks, uneven;
    float most_alpha; /* of the vertices */
};

struct builder {
    struct rnd_scene *scene;
    struct pattern *pattern; /* of each mesh */
    struct rnd_pyramid **pyramid;
    uint32_t pyramids;
    uint32_t capacity;
    float *weight;    /* of each area; 0 once it is divided */
    float *undivided; /* of each divided area, what its weight was */
    double sum;       /* of all weights */
    struct candidate {
        float won; /* how much less its parts could weigh together */
        uint32_t area;
    } * heap; /* largest first */
    uint32_t candidates;
};

/* --- what is uneven --- */

/* NULL if memory is short. */
static struct rnd_pyramid *pyramid_of(struct builder *b, const struct rnd_pyramid_of *of)
{
    for (uint32_t i = 0; i < b->pyramids; i++)
        if (rnd_pyramid_is(b->pyramid[i], of)) return b->pyramid[i];
    struct rnd_pyramid **grown = realloc(b->pyramid, (b->pyramids + 1) * sizeof *grown);
    if (!grown) return NULL;
    b->pyramid = grown;
    struct rnd_pyramid *pyramid = rnd_pyramid_create(of);
    if (pyramid) b->pyramid[b->pyramids++] = pyramid;
    return pyramid;
}

static bool find_pattern(struct builder *b, uint32_t m, struct pattern *out)
{
    const struct rnd_scene *scene = b->scene;
    const struct rnd_mesh *mesh = &scene->mesh[m];
    const struct rnd_material *material = &scene->material[mesh->material];
    const int texture = material->map[RND_MAP_EMISSION].texture;
    *out = (struct pattern){.brightness = rnd_luminance(material->emission.raw), .most_alpha = 1.0f};
    if (texture >= 0) {
        const struct rnd_pyramid_of of = {.texture = &scene->texture[texture],
                                          .channel = RND_PYRAMID_LUMINANCE};
        if (!(out->emission = pyramid_of(b, &of))) return false;
    }
    out->uneven = texture >= 0;
    if (!rnd_has_coverage(scene, m)) return true;

    out->uneven = out->covered = true;
    out->masks = material->alpha_mode == RND_MASK;
    out->alpha = material->alpha;
    out->cutoff = material->alpha_cutoff;
    for (uint32_t i = 0; mesh->colour && i < mesh->vertices; i++)
        out->most_alpha = fmaxf(out->most_alpha, mesh->colour[4 * (size_t)i + 3]);
    bool by_alpha;
    const struct rnd_texture *covers = rnd_coverage_texture(scene, m, &out->coverage_map, &by_alpha);
    if (!covers) return true;
    const float most = out->alpha * out->most_alpha;
    const struct rnd_pyramid_of of = {.texture = covers,
                                      .channel = by_alpha ? RND_PYRAMID_ALPHA : RND_PYRAMID_RED,
                                      .cutoff = !out->masks   ? 0.0f
                                                : most > 0.0f ? out->cutoff / most
                                                              : INFINITY};
    return (out->coverage = pyramid_of(b, &of)) != NULL;
}

/* --- weight --- */

/* A part of a triangle: the barycentric coordinates of one corner, and the distance from there to the other
 * two along u and v, which is negative for the middle one of four parts. */
struct part {
    float u, v, side;
};

/* One of the four parts into which the midpoints of its sides divide it. */
static struct part quarter_of(struct part p, int k)
{
    const float half = 0.5f * p.side;
    return (struct part){p.u + (k & 1 ? half : 0.0f), p.v + (k & 2 ? half : 0.0f), k == 3 ? -half : half};
}

static struct part part_of(const struct rnd_area *area)
{
    struct part p = {0.0f, 0.0f, 1.0f};
    float u, v;
    rnd_area_place(area, 0.0f, 0.0f, &p.u, &p.v);
    rnd_area_place(area, 1.0f, 0.0f, &u, &v);
    p.side = u - p.u;
    return p;
}

/* The distance between sample points of a part, a fourth of its side, in texels. */
static float spacing(const struct rnd_map *map, const struct rnd_pyramid *pyramid,
                     const struct rnd_mesh *mesh, const uint32_t *index, float side)
{
    float a[2], b[2], c[2], most = 0.0f;
    int size[2];
    rnd_pyramid_size(pyramid, size);
    rnd_map_uv(map, mesh, index, 0.0f, 0.0f, a);
    rnd_map_uv(map, mesh, index, 1.0f, 0.0f, b);
    rnd_map_uv(map, mesh, index, 0.0f, 1.0f, c);
    for (int k = 0; k < 2; k++) {
        const float one = fabsf(b[k] - a[k]), other = fabsf(c[k] - a[k]), third = fabsf(c[k] - b[k]);
        most = fmaxf(most, fmaxf(one, fmaxf(other, third)) * (float)size[k]);
    }
    return 0.25f * fabsf(side) * most;
}

/* Largest alpha of the vertices at the corners of a part. */
static float most_vertex_alpha(const struct rnd_mesh *mesh, const uint32_t *index, struct part p)
{
    const float *colour = mesh->colour;
    if (!colour) return 1.0f;
    return fmaxf(rnd_interpolate(colour, 4, 3, index, p.u, p.v),
                 fmaxf(rnd_interpolate(colour, 4, 3, index, p.u + p.side, p.v),
                       rnd_interpolate(colour, 4, 3, index, p.u, p.v + p.side)));
}

/* Coverage around a point of a part. vertex_alpha is the largest alpha of the part's vertices. */
static struct rnd_pyramid_mean covered(const struct pattern *pattern, const struct rnd_mesh *mesh,
                                       const uint32_t *index, const float point[2], float vertex_alpha,
                                       float width)
{
    struct rnd_pyramid_mean mean = {1.0f, 1.0f};
    if (pattern->coverage) {
        float uv[2];
        rnd_map_uv(pattern->coverage_map, mesh, index, point[0], point[1], uv);
        mean = rnd_pyramid_mean(pattern->coverage, pattern->coverage_map->wrap, uv[0], uv[1], width);
    }
    float alpha = pattern->alpha * vertex_alpha;
    if (pattern->masks) alpha = pattern->coverage || alpha >= pattern->cutoff ? 1.0f : 0.0f;
    return (struct rnd_pyramid_mean){alpha * mean.value, alpha * alpha * mean.square};
}

/* The part of a mesh that is weighed, and the distance between its sample points in texels of the emission
 * and of the coverage. */
struct weighed_part {
    const struct pattern *pattern;
    const struct rnd_mesh *mesh;
    const struct rnd_map *map;
    const uint32_t *index;
    float step, cover_step;
};

/* Emission times coverage around a point, without the brightness: means over squares that are wider than the
 * distance between sample points by that many texels. */
static struct rnd_pyramid_mean around(const struct weighed_part *s, const float point[2], float vertex_alpha,
                                      float wider)
{
    struct rnd_pyramid_mean emits = {1.0f, 1.0f}, there = {1.0f, 1.0f};
    if (s->pattern->emission) {
        float uv[2];
        rnd_map_uv(s->map, s->mesh, s->index, point[0], point[1], uv);
        emits = rnd_pyramid_mean(s->pattern->emission, s->map->wrap, uv[0], uv[1], s->step + wider);
    }
    if (s->pattern->covered)
        there = covered(s->pattern, s->mesh, s->index, point, vertex_alpha, s->cover_step + wider);
    return (struct rnd_pyramid_mean){emits.value * there.value, emits.square * there.square};
}

/* Luminance of a part, from four sample points in each of its quarters. Light beyond the outermost points is
 * within squares a texel wider: a thousandth of their mean is added, so that a part that shines anywhere has
 * some weight. */
static struct rnd_pyramid_mean shine(const struct builder *b, const struct rnd_area *area, struct part part)
{
    const struct rnd_mesh *mesh = &b->scene->mesh[area->mesh];
    const struct pattern *pattern = &b->pattern[area->mesh];
    struct weighed_part weighed = {.pattern = pattern,
                                   .mesh = mesh,
                                   .map = &b->scene->material[mesh->material].map[RND_MAP_EMISSION],
                                   .index = mesh->index[area->triangle]};
    if (pattern->emission)
        weighed.step = spacing(weighed.map, pattern->emission, mesh, weighed.index, part.side);
    if (pattern->coverage)
        weighed.cover_step =
            spacing(pattern->coverage_map, pattern->coverage, mesh, weighed.index, part.side);
    struct rnd_pyramid_mean sum = {0};
    for (int k = 0; k < 4; k++) {
        const struct part quarter = quarter_of(part, k);
        const float alpha = most_vertex_alpha(mesh, weighed.index, quarter);
        for (int i = 0; i < 4; i++) {
            const struct part p = quarter_of(quarter, i);
            const float point[2] = {p.u + p.side / 3.0f, p.v + p.side / 3.0f};
            const struct rnd_pyramid_mean own = around(&weighed, point, alpha, 0.0f),
                                          more = around(&weighed, point, alpha, 1.0f);
            sum.value += own.value / 16.0f;
            sum.square += (own.square + 1e-3f * more.square) / 16.0f;
        }
    }
    return sum;
}

/* Weight of an area: its power, with the root mean square of the emission in place of the mean, which draws
 * strata best (Cochran 1977, section 5.5). *out_won: how much less its parts would weigh together if each
 * were even. */
static float weigh(const struct builder *b, const struct rnd_area *area, float *out_won)
{
    const struct rnd_v3 twice = rnd_v3_cross(area->e1, area->e2);
    const float size =
        0.5f * sqrtf(rnd_v3_dot(twice, twice)) * (float)M_PI * (area->flags & RND_AREA_DOUBLE ? 2.0f : 1.0f);
    const struct pattern *pattern = &b->pattern[area->mesh];
    *out_won = 0.0f;
    if (!pattern->uneven) return size * pattern->brightness;
    const struct rnd_pyramid_mean mean = shine(b, area, part_of(area));
    const float root = pattern->brightness * sqrtf(mean.square);
    *out_won = size * fmaxf(root - pattern->brightness * mean.value, 0.0f);
    return size * root;
}

/* --- division --- */

static bool before(const struct candidate *a, const struct candidate *b)
{
    return a->won != b->won ? a->won > b->won : a->area < b->area;
}

static void push(struct builder *b, struct candidate new)
{
    uint32_t i = b->candidates++;
    for (; i > 0 && before(&new, &b->heap[(i - 1) / 2]); i = (i - 1) / 2) b->heap[i] = b->heap[(i - 1) / 2];
    b->heap[i] = new;
}

static struct candidate pop(struct builder *b)
{
    const struct candidate top = b->heap[0], last = b->heap[--b->candidates];
    uint32_t i = 0;
    for (;;) {
        uint32_t child = 2 * i + 1;
        if (child >= b->candidates) break;
        child += child + 1 < b->candidates && before(&b->heap[child + 1], &b->heap[child]);
        if (!before(&b->heap[child], &last)) break;
        b->heap[i] = b->heap[child];
        i = child;
    }
    b->heap[i] = last;
    return top;
}

/* Weigh the newest area, and note what its division could win. */
static void take(struct builder *b)
{
    struct rnd_lights *lights = &b->scene->lights;
    const uint32_t i = lights->area_count++;
    float won;
    b->sum += (double)(b->weight[i] = weigh(b, &lights->area[i], &won));
    if (won > 0.0f) push(b, (struct candidate){won, i});
}

/* Put four areas in place of one, which is then not drawn. */
static void divide(struct builder *b, uint32_t i)
{
    struct rnd_lights *lights = &b->scene->lights;
    const struct rnd_area whole = lights->area[i];
    const uint32_t halvings = (whole.flags >> RND_AREA_HALVINGS) + 1;
    const struct rnd_v3 e1 = rnd_v3_scale(whole.e1, 0.5f), e2 = rnd_v3_scale(whole.e2, 0.5f);
    lights->area[i].flags |= RND_AREA_DIVIDED;
    lights->area[i].place = lights->area_count;
    b->sum -= (double)b->weight[i];
    b->undivided[i] = b->weight[i];
    b->weight[i] = 0.0f;
    for (int k = 0; k < 4; k++) {
        const struct part part = quarter_of(part_of(&whole), k);
        const float steps = (float)(1u << halvings);
        struct rnd_area *quarter = &lights->area[lights->area_count];
        *quarter = whole;
        if (k & 1) quarter->corner = rnd_v3_add(quarter->corner, e1);
        if (k & 2) quarter->corner = rnd_v3_add(quarter->corner, e2);
        quarter->e1 = k == 3 ? rnd_v3_scale(e1, -1.0f) : e1;
        quarter->e2 = k == 3 ? rnd_v3_scale(e2, -1.0f) : e2;
        quarter->place = (uint32_t)(part.u * steps) | (uint32_t)(part.v * steps) << 16;
        quarter->flags = (whole.flags & (RND_AREA_TEXTURED | RND_AREA_COVERED | RND_AREA_DOUBLE)) |
                         (part.side < 0.0f ? RND_AREA_TURNED : 0) | halvings << RND_AREA_HALVINGS;
        take(b);
    }
}

/* Divide areas, first the one that wins most. */
static void divide_all(struct builder *b)
{
    const struct rnd_lights *lights = &b->scene->lights;
    while (b->candidates > 0 && lights->area_count + 4 <= b->capacity) {
        const struct candidate best = pop(b);
        if (!((double)best.won > LEAST_WON * b->sum)) break;
        if (lights->area[best.area].flags >> RND_AREA_HALVINGS < HALVINGS) divide(b, best.area);
    }
}

/* Stop drawing an area and all its parts. */
static void drop(struct builder *b, uint32_t i)
{
    const struct rnd_area *area = &b->scene->lights.area[i];
    b->weight[i] = 0.0f;
    for (uint32_t k = 0; area->flags & RND_AREA_DIVIDED && k < 4; k++) drop(b, area->place + k);
}

/* The corner of a divided area, from its first part, in steps of the area's sides. The part has the same
 * corner, in steps half as long. */
static uint32_t corner_of(const struct rnd_area *areas, uint32_t part)
{
    int halvings = 1;
    for (; areas[part].flags & RND_AREA_DIVIDED; halvings++) part = areas[part].place;
    return (areas[part].place & 0xffffu) >> halvings | areas[part].place >> (16 + halvings) << 16;
}

/* Undo divisions that won too little. An area comes before its parts. */
static void join(struct builder *b)
{
    struct rnd_area *areas = b->scene->lights.area;
    float *weight = b->weight; /* for a divided area, the sum of its parts instead of 0 */
    for (uint32_t i = b->scene->lights.area_count; i-- > 0;) {
        struct rnd_area *area = &areas[i];
        if (!(area->flags & RND_AREA_DIVIDED)) continue;
        const uint32_t first = area->place;
        const float parts = weight[first] + weight[first + 1] + weight[first + 2] + weight[first + 3];
        weight[i] = parts;
        if (parts < (1.0f - LEAST_KEPT) * b->undivided[i]) continue;
        drop(b, i);
        weight[i] = b->undivided[i];
        area->flags &= ~(uint32_t)RND_AREA_DIVIDED;
        area->place = corner_of(areas, first);
    }
    for (uint32_t i = 0; i < b->scene->lights.area_count; i++)
        if (areas[i].flags & RND_AREA_DIVIDED) weight[i] = 0.0f;
}

/* --- all --- */

static struct rnd_area make_area(const struct rnd_scene *scene, uint32_t m, uint32_t triangle)
{
    const struct rnd_mesh *mesh = &scene->mesh[m];
    const struct rnd_material *material = &scene->material[mesh->material];
    struct rnd_v3 p[3];
    for (int k = 0; k < 3; k++) {
        const float *from = mesh->position + 3 * (size_t)mesh->index[triangle][k];
        p[k] = rnd_v3(from[0], from[1], from[2]);
    }
    return (struct rnd_area){.corner = p[0],
                             .e1 = rnd_v3_sub(p[1], p[0]),
                             .e2 = rnd_v3_sub(p[2], p[0]),
                             .emission =
                                 rnd_v3(material->emission.x, material->emission.y, material->emission.z),
                             .mesh = m,
                             .triangle = triangle,
                             .flags = (material->map[RND_MAP_EMISSION].texture >= 0 ? RND_AREA_TEXTURED : 0) |
                                      (rnd_has_coverage(scene, m) ? RND_AREA_COVERED : 0) |
                                      (material->double_sided ? RND_AREA_DOUBLE : 0)};
}

/* All triangles that emit, and whether some are uneven. */
static uint64_t count_emitters(struct builder *b, bool *out_ok)
{
    const struct rnd_scene *scene = b->scene;
    uint64_t count = 0;
    *out_ok = (b->pattern = calloc(scene->mesh_count + 1, sizeof *b->pattern)) != NULL;
    for (uint32_t m = 0; *out_ok && m < scene->mesh_count; m++) {
        if (!rnd_emits(&scene->material[scene->mesh[m].material])) continue;
        count += scene->mesh[m].triangles;
        *out_ok = find_pattern(b, m, &b->pattern[m]);
        b->scene->lights.area_uneven |= b->pattern[m].uneven;
    }
    return count;
}

/* Fill lights->area, and mark the meshes. *out_weight: of each area, in proportion to which it is to be
 * drawn; the caller frees it. */
static bool find_areas(struct rnd_scene *scene, float **out_weight)
{
    struct rnd_lights *lights = &scene->lights;
    struct builder b = {.scene = scene};
    bool ok;
    const uint64_t count = scene->info.emissive_triangles = count_emitters(&b, &ok);
    *out_weight = NULL;
    if (!ok || count == 0) goto end;
    const uint64_t capacity = count + (lights->area_uneven ? 4 * (uint64_t)DIVISIONS : 0);
    b.capacity = (uint32_t)capacity;
    lights->area = aligned_alloc(64, capacity * sizeof *lights->area); /* a line of the cache each */
    b.weight = malloc(capacity * sizeof *b.weight);
    b.heap = malloc((lights->area_uneven ? capacity : 1) * sizeof *b.heap);
    b.undivided = malloc((lights->area_uneven ? capacity : 1) * sizeof *b.undivided);
    ok = capacity < UINT32_MAX && lights->area && b.weight && b.heap && b.undivided;
    for (uint32_t m = 0; ok && m < scene->mesh_count; m++) {
        struct rnd_mesh *mesh = &scene->mesh[m];
        if (!rnd_emits(&scene->material[mesh->material])) continue;
        mesh->first_light = lights->area_count;
        for (uint32_t t = 0; t < mesh->triangles; t++) {
            lights->area[lights->area_count] = make_area(scene, m, t);
            take(&b);
        }
    }
    if (ok) divide_all(&b);
    if (ok) join(&b);
    *out_weight = b.weight;
end:
    for (uint32_t i = 0; i < b.pyramids; i++) rnd_pyramid_destroy(b.pyramid[i]);
    free(b.pyramid);
    free(b.pattern);
    free(b.heap);
    free(b.undivided);
    return ok;
}

bool rnd_areas_build(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    float *weight;
    double sum = 0.0;
    bool ok = find_areas(scene, &weight);
    if (!ok || lights->area_count == 0) goto end;
    vec3s *position = malloc(lights->area_count * sizeof *position);
    ok = position != NULL;
    for (uint32_t i = 0; ok && i < lights->area_count; i++) {
        const struct rnd_area *area = &lights->area[i];
        const struct rnd_v3 middle = rnd_v3_muladd(rnd_v3_add(area->e1, area->e2), 1.0f / 3.0f, area->corner);
        position[i] = (vec3s){{middle.x, middle.y, middle.z}};
        sum += (double)weight[i];
    }
    if (ok && sum > 0.0 && isfinite(sum))
        ok = rnd_emitters_build(&lights->emitters[RND_LIGHT_AREA], position, weight, lights->area_count);
    free(position);
end:
    *out_power = sum;
    free(weight);
    return ok;
}
