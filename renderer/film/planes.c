/* Planes: the table of them, and the memory of a film that has some. */
#include "film/planes.h"
#include "material/surface.h"
#include "math/half.h"
#include "renderer.h"

#include <math.h>

static void put(vec3s value, float *out)
{
    for (int c = 0; c < 3; c++) out[c] = value.raw[c];
}

static void albedo(const struct rnd_surface *surface, uint32_t instance, float *out)
{
    (void)instance;
    put(surface->base, out);
}

static void normal(const struct rnd_surface *surface, uint32_t instance, float *out)
{
    (void)instance;
    put(surface->shading, out);
}

static void position(const struct rnd_surface *surface, uint32_t instance, float *out)
{
    (void)instance;
    put(surface->position, out);
}

static void coverage(const struct rnd_surface *surface, uint32_t instance, float *out)
{
    (void)surface, (void)instance;
    *out = 1.0f;
}

static void instance_number(const struct rnd_surface *surface, uint32_t instance, float *out)
{
    (void)surface;
    *out = (float)instance;
}

/* Channels are named as compositors know them: LAYER.R or LAYER.X (OpenEXR's layers). */
static const struct rnd_plane table[RND_PLANES] = {
    [RND_PLANE_ALBEDO] = {.name = "albedo",
                          .summary = "base colour of the surface",
                          .channels = 3,
                          .channel = {"albedo.R", "albedo.G", "albedo.B"},
                          .form = RND_PLANE_HALVES,
                          .gather = albedo},
    [RND_PLANE_NORMAL] = {.name = "normal",
                          .summary = "its normal in the world, facing the camera",
                          .channels = 3,
                          .channel = {"normal.X", "normal.Y", "normal.Z"},
                          .form = RND_PLANE_HALVES,
                          .gather = normal},
    [RND_PLANE_POSITION] = {.name = "position",
                            .summary = "its place in the world, m; coverage comes with it",
                            .channels = 3,
                            .channel = {"position.X", "position.Y", "position.Z"},
                            .form = RND_PLANE_FLOATS,
                            .gather = position},
    [RND_PLANE_COVERAGE] = {.name = "coverage",
                            .summary = "share of the paths that hit a surface; the others saw the sky",
                            .channels = 1,
                            .channel = {"coverage"},
                            .form = RND_PLANE_HALVES,
                            .gather = coverage},
    [RND_PLANE_INSTANCE] = {.name = "instance",
                            .summary = "number of the mesh or instance, from 1",
                            .channels = 1,
                            .channel = {"instance"},
                            .form = RND_PLANE_LAST,
                            .gather = instance_number},
};

const char *rnd_plane_at(size_t index, const char **out_summary)
{
    const struct rnd_plane *plane = index < RND_PLANES ? &table[index] : NULL;
    *out_summary = plane ? plane->summary : NULL;
    return plane ? plane->name : NULL;
}

void rnd_planes_init(struct rnd_planes *planes, uint32_t asked)
{
    *planes = (struct rnd_planes){0};
    for (int p = 0; p < RND_PLANES; p++) {
        planes->first[p] = asked >> p & 1u ? planes->channels : -1;
        for (int c = 0; planes->first[p] >= 0 && c < table[p].channels; c++) {
            planes->plane[planes->channels] = (uint8_t)p;
            planes->at[planes->channels++] = (uint8_t)planes->bytes;
            planes->bytes += table[p].form == RND_PLANE_HALVES ? sizeof(uint16_t) : sizeof(float);
        }
    }
}

void rnd_planes_gather(const struct rnd_planes *planes, const struct rnd_surface *surface, uint32_t instance,
                       float *out)
{
    for (int p = 0; p < RND_PLANES; p++)
        if (planes->first[p] >= 0) table[p].gather(surface, instance, out + planes->first[p]);
    for (int c = 0; c < planes->channels; c++) out[c] = isfinite(out[c]) ? out[c] : 0.0f;
}

/* --- memory of a tile --- */

size_t rnd_planes_size(const struct rnd_planes *planes, uint32_t pixels, uint32_t blocks)
{
    return (size_t)blocks * (size_t)planes->channels * sizeof(float) + (size_t)pixels * planes->bytes;
}

static enum rnd_plane_form form_of(const struct rnd_planes *planes, int channel)
{
    return table[planes->plane[channel]].form;
}

const char *rnd_planes_channel(const struct rnd_planes *planes, int channel, bool *out_floats)
{
    const int plane = planes->plane[channel];
    *out_floats = form_of(planes, channel) != RND_PLANE_HALVES;
    return table[plane].channel[channel - planes->first[plane]];
}

/* A channel of a record, which is aligned to nothing. */
static float get(const struct rnd_planes *planes, const void *record, int channel)
{
    const uint8_t *from = (const uint8_t *)record + planes->at[channel];
    uint16_t half;
    float value;
    if (form_of(planes, channel) == RND_PLANE_HALVES) {
        memcpy(&half, from, sizeof half);
        return rnd_half_decode(half);
    }
    memcpy(&value, from, sizeof value);
    return value;
}

/* Returns the value as it is kept. */
static float set(const struct rnd_planes *planes, void *record, int channel, float value)
{
    uint8_t *to = (uint8_t *)record + planes->at[channel];
    if (form_of(planes, channel) == RND_PLANE_HALVES) {
        const uint16_t half = rnd_half_encode(value);
        memcpy(to, &half, sizeof half);
        return rnd_half_decode(half);
    }
    memcpy(to, &value, sizeof value);
    return value;
}

void rnd_planes_add(const struct rnd_planes *planes, void *record, float *block, uint32_t paths,
                    const float *values)
{
    const float share = 1.0f / (float)(paths + 1);
    for (int c = 0; c < planes->channels; c++) {
        const float before = paths > 0 ? get(planes, record, c) : 0.0f;
        if (form_of(planes, c) == RND_PLANE_LAST)
            block[c] = set(planes, record, c, values[c]);
        else
            block[c] += set(planes, record, c, before + (values[c] - before) * share) - before;
    }
}

static void add(const struct rnd_planes *planes, int channel, float value, float *sum)
{
    sum[channel] = form_of(planes, channel) == RND_PLANE_LAST ? value : sum[channel] + value;
}

void rnd_planes_sum(const struct rnd_planes *planes, const void *record, float *sum)
{
    for (int c = 0; c < planes->channels; c++) add(planes, c, get(planes, record, c), sum);
}

void rnd_planes_sum_block(const struct rnd_planes *planes, const float *block, uint32_t pixels, float *sum)
{
    for (int c = 0; c < planes->channels; c++) {
        const bool has_mean = form_of(planes, c) != RND_PLANE_LAST;
        add(planes, c, has_mean ? block[c] / (float)pixels : block[c], sum);
    }
}

void rnd_planes_divide(const struct rnd_planes *planes, float count, float *sum)
{
    for (int c = 0; c < planes->channels; c++)
        if (form_of(planes, c) != RND_PLANE_LAST) sum[c] /= count;
}
