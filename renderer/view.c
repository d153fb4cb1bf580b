/* A rectilinear view of an equirectangular picture, trilinear over its mipmap so that poles and wide views
 * are calm (Koskela 2018, section 4.3).
 */
#include "renderer.h"
#include "sphere.h"

#include <stdlib.h>

enum { MAX_LEVELS = 16 };

struct mipmap {
    int levels, width[MAX_LEVELS], height[MAX_LEVELS];
    const float *rgb[MAX_LEVELS]; /* level 0 is the caller's */
    float *own;
};

static bool mipmap_init(struct mipmap *map, const float *rgb, int width, int height)
{
    *map = (struct mipmap){.levels = 1, .width = {width}, .height = {height}, .rgb = {rgb}};
    size_t count = 0;
    while (map->levels < MAX_LEVELS && width > 1 && height > 1) {
        map->width[map->levels] = width /= 2;
        map->height[map->levels++] = height /= 2;
        count += (size_t)width * height * 3;
    }
    if (!(map->own = malloc((count + 1) * sizeof *map->own))) return false;
    float *to = map->own;
    for (int l = 1; l < map->levels; l++) {
        const float *from = map->rgb[l - 1];
        const size_t above = map->width[l - 1];
        map->rgb[l] = to;
        for (int y = 0; y < map->height[l]; y++)
            for (int x = 0; x < map->width[l]; x++)
                for (int c = 0; c < 3; c++) {
                    const float *p = from + (2 * y * above + 2 * (size_t)x) * 3 + c;
                    *to++ = 0.25f * (p[0] + p[3] + p[3 * above] + p[3 * above + 3]);
                }
    }
    return true;
}

static vec3s bilinear(const struct mipmap *map, int level, float u, float v)
{
    const int w = map->width[level], h = map->height[level];
    const float x = u * w - 0.5f, y = v * h - 0.5f;
    const int x0 = (int)floorf(x), y0 = (int)floorf(y);
    vec3s sum = glms_vec3_zero();
    for (int i = 0; i < 4; i++) {
        const int px = (x0 + (i & 1) + w) % w, row = y0 + (i >> 1), py = row < 0 ? 0 : row >= h ? h - 1 : row;
        const float weight = (i & 1 ? x - x0 : 1.0f - (x - x0)) * (i >> 1 ? y - y0 : 1.0f - (y - y0));
        sum = glms_vec3_muladds(rnd_vec(map->rgb[level] + 3 * ((size_t)py * w + px)), weight, sum);
    }
    return sum;
}

static vec3s trilinear(const struct mipmap *map, float u, float v, float level)
{
    const float l = fmaxf(0.0f, fminf(level, (float)(map->levels - 1)));
    const int l0 = (int)l, l1 = l0 + 1 < map->levels ? l0 + 1 : l0;
    return glms_vec3_lerp(bilinear(map, l0, u, v), bilinear(map, l1, u, v), l - (float)l0);
}

/* What a pixel of the view shows: its square, pixel a side at distance 1 from (x, y), by rays over which the
 * mean is taken. Towards a pole texels crowd along the parallels, and so do the rays; what remains of the
 * footprint is left to the mipmap, at the mean of the two axes' levels. */
static vec3s pixel_mean(const struct mipmap *map, versors orientation, float x, float y, float pixel)
{
    enum { MOST = 4 }; /* rays a side */
    const float texels_u = (float)(map->width[0] / (2.0 * M_PI)), texels_v = (float)(map->height[0] / M_PI);
    const vec3s middle = {{x, y, -1.0f}}, d = glms_quat_rotatev(orientation, glms_vec3_normalize(middle));
    const float angle = pixel / glms_vec3_norm2(middle), least = 1.0f / (float)map->width[0];
    const float crowd =
        angle * texels_u / fmaxf(sqrtf(d.x * d.x + d.z * d.z), least) / fmaxf(angle * texels_v, 1);
    const int rays = crowd <= 1.0f ? 1 : (int)fminf(ceilf(sqrtf(crowd)), MOST);
    const float step = pixel / (float)rays;
    vec3s sum = glms_vec3_zero();
    for (int i = 0; i < rays * rays; i++) {
        const vec3s p = {{x + ((float)(i % rays) + 0.5f) * step - 0.5f * pixel,
                          y + ((float)(i / rays) + 0.5f) * step - 0.5f * pixel, -1.0f}};
        const vec3s ray = glms_quat_rotatev(orientation, glms_vec3_normalize(p));
        float u, v;
        rnd_to_uv(ray, &u, &v);
        const float across =
            angle / (float)rays * texels_u / fmaxf(sqrtf(ray.x * ray.x + ray.z * ray.z), least);
        const float down = angle / (float)rays * texels_v;
        const float level =
            0.5f * (log2f(fmaxf(1.0f, fminf(across, (float)map->width[0]))) + log2f(fmaxf(1.0f, down)));
        sum = glms_vec3_add(sum, trilinear(map, u, v, level));
    }
    return glms_vec3_scale(sum, 1.0f / (float)(rays * rays));
}

bool rnd_image_view(const float *rgb, int width, int height, const float orientation[4], float fov_x,
                    int out_width, int out_height, float *out_rgb)
{
    struct mipmap map;
    if (!mipmap_init(&map, rgb, width, height)) return false;
    const versors q = {{orientation[0], orientation[1], orientation[2], orientation[3]}};
    const float pixel = 2.0f * tanf(0.5f * fov_x) / (float)out_width; /* at distance 1 */
    for (int y = 0; y < out_height; y++)
        for (int x = 0; x < out_width; x++) {
            const vec3s c = pixel_mean(&map, q, ((float)x + 0.5f - 0.5f * out_width) * pixel,
                                       (0.5f * out_height - (float)y - 0.5f) * pixel, pixel);
            glm_vec3_copy((float *)c.raw, out_rgb + 3 * ((size_t)y * out_width + x));
        }
    free(map.own);
    return true;
}
