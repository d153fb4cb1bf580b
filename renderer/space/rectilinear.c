/* A rectilinear view of an equirectangular picture, trilinear over its mipmap so that poles and wide views
 * are calm (Koskela 2018, section 4.3).
 */
#include "renderer.h"
#include "math/sphere.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_LEVELS = 16 };

struct mipmap {
    int levels, width[MAX_LEVELS], height[MAX_LEVELS];
    float *rgb[MAX_LEVELS];
    float *memory; /* of all levels */
};

/* Halve a level. Rows count by their solid angle. */
static void halve(const float *from, int width, int height, float *to)
{
    for (int y = 0; y < height / 2; y++) {
        const float above = rnd_row_weight(2 * y, height), below = rnd_row_weight(2 * y + 1, height);
        const float weight[2] = {0.5f * above / (above + below), 0.5f * below / (above + below)};
        for (int x = 0; x < width / 2; x++)
            for (int c = 0; c < 3; c++) {
                const float *p = from + (2 * (size_t)y * width + 2 * (size_t)x) * 3 + c, *q = p + 3 * width;
                *to++ = weight[0] * (p[0] + p[3]) + weight[1] * (q[0] + q[3]);
            }
    }
}

/* On the sphere the texels of a row are narrower than high. Replace each by the mean over an interval around
 * it that is as wide as a texel is high. prefix has room for width + 1 sums. */
static void widen_row(float *row, int width, int y, int height, double (*prefix)[3])
{
    const double wide = fmin(1.0 / rnd_row_weight(y, height), width);
    if (wide < 1.001) return;
    memset(prefix[0], 0, sizeof prefix[0]);
    for (int x = 0; x < width; x++)
        for (int c = 0; c < 3; c++) prefix[x + 1][c] = prefix[x][c] + row[3 * x + c];
    for (int x = 0; x < width; x++)
        for (int c = 0; c < 3; c++) {
            double sum = 0.0;
            for (int end = 0; end < 2; end++) { /* the integral up to each end of the mean's interval */
                const double at = x + 0.5 + (end ? 0.5 : -0.5) * wide, turns = floor(at / width);
                const double within = at - turns * width;
                const int i = within < width ? (int)within : width - 1;
                const double integral = turns * prefix[width][c] + prefix[i][c] +
                                        (within - i) * (prefix[i + 1][c] - prefix[i][c]);
                sum += end ? integral : -integral;
            }
            row[3 * x + c] = (float)(sum / wide);
        }
}

static bool mipmap_init(struct mipmap *map, const float *rgb, int width, int height)
{
    *map = (struct mipmap){.levels = 1, .width = {width}, .height = {height}};
    size_t count = (size_t)width * height * 3;
    while (map->levels < MAX_LEVELS && width > 1 && height > 1) {
        map->width[map->levels] = width /= 2;
        map->height[map->levels++] = height /= 2;
        count += (size_t)width * height * 3;
    }
    double(*prefix)[3] = malloc(((size_t)map->width[0] + 1) * sizeof *prefix);
    float *to = map->memory = malloc(count * sizeof *map->memory);
    if (!prefix || !to) {
        free(prefix);
        free(to);
        return false;
    }
    memcpy(to, rgb, (size_t)map->width[0] * map->height[0] * 3 * sizeof *to);
    for (int l = 0; l < map->levels; l++) {
        if (l > 0) halve(map->rgb[l - 1], map->width[l - 1], map->height[l - 1], to);
        map->rgb[l] = to;
        to += (size_t)map->width[l] * map->height[l] * 3;
    }
    for (int l = 0; l < map->levels; l++)
        for (int y = 0; y < map->height[l]; y++)
            widen_row(map->rgb[l] + 3 * (size_t)y * map->width[l], map->width[l], y, map->height[l], prefix);
    free(prefix);
    return true;
}

static vec3s bilinear(const struct mipmap *map, int level, float u, float v)
{
    const int w = map->width[level], h = map->height[level];
    const float y = v * h - 0.5f;
    const int y0 = (int)floorf(y);
    vec3s sum = glms_vec3_zero();
    for (int r = 0; r < 2; r++) {
        /* Beyond a pole is the same row again, half a turn further. */
        const int row = y0 + r, py = row < 0 ? -1 - row : row >= h ? 2 * h - 1 - row : row;
        const float x = (py == row ? u : u + 0.5f) * w - 0.5f;
        const int x0 = (int)floorf(x);
        for (int i = 0; i < 2; i++) {
            const int px = (x0 + i + 2 * w) % w;
            const float weight = (i ? x - x0 : 1.0f - (x - x0)) * (r ? y - y0 : 1.0f - (y - y0));
            sum = glms_vec3_muladds(rnd_vec(map->rgb[level] + 3 * ((size_t)py * w + px)), weight, sum);
        }
    }
    return sum;
}

static vec3s trilinear(const struct mipmap *map, float u, float v, float level)
{
    const float l = fmaxf(0.0f, fminf(level, (float)(map->levels - 1)));
    const int l0 = (int)l, l1 = l0 + 1 < map->levels ? l0 + 1 : l0;
    return glms_vec3_lerp(bilinear(map, l0, u, v), bilinear(map, l1, u, v), l - (float)l0);
}

/* Mean over a pixel of the view: a square of that side around (x, y) at distance 1. On the sphere the texels
 * of every level are as wide as high, so the height of the pixel tells the level. */
static vec3s pixel_mean(const struct mipmap *map, versors orientation, float x, float y, float pixel)
{
    const vec3s middle = {{x, y, -1.0f}}, d = glms_quat_rotatev(orientation, glms_vec3_normalize(middle));
    const float angle = pixel / glms_vec3_norm2(middle);
    float u, v;
    rnd_to_uv(d, &u, &v);
    return trilinear(map, u, v, log2f(fmaxf(1.0f, angle * (float)(map->height[0] / M_PI))));
}

bool rnd_image_view(const float *rgb, int width, int height, const struct rnd_view *view, float *out_rgb)
{
    const int out_width = view->width, out_height = view->height;
    const float *q = view->orientation;
    struct mipmap map;
    if (!mipmap_init(&map, rgb, width, height)) return false;
    const versors orientation = {{q[0], q[1], q[2], q[3]}};
    const float pixel = 2.0f * tanf(0.5f * view->fov_x) / (float)out_width; /* at distance 1 */
    for (int y = 0; y < out_height; y++)
        for (int x = 0; x < out_width; x++) {
            const vec3s c = pixel_mean(&map, orientation, ((float)x + 0.5f - 0.5f * out_width) * pixel,
                                       (0.5f * out_height - (float)y - 0.5f) * pixel, pixel);
            glm_vec3_copy((float *)c.raw, out_rgb + 3 * ((size_t)y * out_width + x));
        }
    free(map.memory);
    return true;
}
