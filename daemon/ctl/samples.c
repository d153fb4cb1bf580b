/* foveactl samples: draws where the samples of a saved film fell, and the path of the gaze. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ctl.h"
#include "image.h"
#include "tracker.h"

enum { MOST_WIDTH = 2048 };

/* Half widths of the line, the marks and their rims, pixels. */
static const float LINE_PX = 0.8f, MARK_PX = 6, RIM_PX = 1.5f;
static const float LINE_COLOUR[3] = {0.25f, 1, 0.95f}, FIRST_COLOUR[3] = {0.2f, 1, 0.3f},
                   LAST_COLOUR[3] = {1, 0.35f, 0.3f};

struct map {
    int width, height;
    float *rgb;   /* linear */
    float *cover; /* coverage by the line, 0 to 1 */
};

/* Replace squares of pixels by their means, in place, so that the map is at most MOST_WIDTH wide. Returns the
 * largest. */
static float shrink(float *counts, int width, int height, struct map *map)
{
    int side = (width + MOST_WIDTH - 1) / MOST_WIDTH;
    float most = 0;

    map->width = width / side;
    map->height = height / side;
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            double sum = 0;

            for (int j = 0; j < side; j++)
                for (int i = 0; i < side; i++) sum += counts[(size_t)(y * side + j) * width + x * side + i];
            counts[(size_t)y * map->width + x] = (float)(sum / (side * side));
            most = fmaxf(most, (float)(sum / (side * side)));
        }
    return most;
}

/* Draw a segment of the line. Each pixel keeps the greater coverage, so that joints are no brighter. */
static void cover_segment(struct map *map, const float a[2], const float b[2])
{
    float reach = LINE_PX + 1, d[2] = {b[0] - a[0], b[1] - a[1]}, square = d[0] * d[0] + d[1] * d[1];
    int low_x = (int)floorf(fminf(a[0], b[0]) - reach), high_x = (int)ceilf(fmaxf(a[0], b[0]) + reach);
    int low_y = (int)floorf(fminf(a[1], b[1]) - reach), high_y = (int)ceilf(fmaxf(a[1], b[1]) + reach);

    for (int y = low_y < 0 ? 0 : low_y; y <= high_y && y < map->height; y++)
        for (int x = low_x < 0 ? 0 : low_x; x <= high_x && x < map->width; x++) {
            float p[2] = {(float)x + 0.5f - a[0], (float)y + 0.5f - a[1]}, along, distance;
            float *cover = &map->cover[(size_t)y * map->width + x];

            along = square > 0 ? fminf(1, fmaxf(0, (p[0] * d[0] + p[1] * d[1]) / square)) : 0;
            distance = hypotf(p[0] - along * d[0], p[1] - along * d[1]);
            *cover = fmaxf(*cover, fminf(1, fmaxf(0, LINE_PX + 0.5f - distance)));
        }
}

static void blend(struct map *map, int x, int y, const float to[3], float share)
{
    float *pixel = &map->rgb[((size_t)y * map->width + x) * 3];

    for (int c = 0; c < 3; c++) pixel[c] += (to[c] - pixel[c]) * share;
}

/* Draw a disc with a dark rim. */
static void mark(struct map *map, const float at[2], const float colour_of[3])
{
    static const float DARK[3] = {0, 0, 0};
    int reach = (int)(MARK_PX + RIM_PX + 2);

    for (int y = (int)at[1] - reach; y <= (int)at[1] + reach; y++)
        for (int x = (int)at[0] - reach; x <= (int)at[0] + reach; x++) {
            float distance = hypotf((float)x + 0.5f - at[0], (float)y + 0.5f - at[1]);

            if (x < 0 || y < 0 || x >= map->width || y >= map->height) continue;
            blend(map, x, y, DARK, fminf(1, fmaxf(0, MARK_PX + RIM_PX + 0.5f - distance)));
            blend(map, x, y, colour_of, fminf(1, fmaxf(0, MARK_PX + 0.5f - distance)));
        }
}

static void draw_path(struct map *map, const struct trk_log *log)
{
    float last[2] = {0, 0}, first[2] = {0, 0};
    bool any = false, joined = false;

    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        float d[3], at[2];

        trk_log_sample(log, i, &sample);
        if (!trk_world_direction(&sample, d)) {
            joined = false;
            continue;
        }
        at[0] = (0.5f + atan2f(d[0], -d[2]) / (2 * (float)M_PI)) * (float)map->width;
        at[1] = (0.5f - asinf(fmaxf(-1, fminf(1, d[1]))) / (float)M_PI) * (float)map->height;
        /* A step of half the width crosses the seam. */
        if (joined && fabsf(at[0] - last[0]) < (float)map->width / 2) cover_segment(map, last, at);
        for (int c = 0; c < 2; c++) last[c] = at[c];
        for (int c = 0; c < 2 && !any; c++) first[c] = at[c];
        any = joined = true;
    }
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++)
            blend(map, x, y, LINE_COLOUR, map->cover[(size_t)y * map->width + x]);
    if (any) mark(map, first, FIRST_COLOUR);
    if (any) mark(map, last, LAST_COLOUR);
}

static bool draw(const struct ctl *ctl, float *counts, int width, int height, const struct trk_log *log)
{
    struct map map = {0};
    char error[RND_ERROR_SIZE];
    float most = shrink(counts, width, height, &map), scale = most > 0 ? 1 / log1pf(most) : 0;
    size_t pixels = (size_t)map.width * map.height;
    bool good = false;

    map.rgb = malloc(pixels * 3 * sizeof(*map.rgb));
    map.cover = calloc(pixels, sizeof(*map.cover));
    if (!map.rgb || !map.cover) {
        ctl_fail("out of memory");
        goto end;
    }
    for (size_t i = 0; i < pixels; i++) ctl_colour(CTL_INFERNO, log1pf(counts[i]) * scale, &map.rgb[3 * i]);
    if (log) draw_path(&map, log);
    /* Where somebody looked is private, as a log of it is. */
    good = dmn_image_write(ctl->operand[1], 0600, map.width, map.height, map.rgb, true, error) ||
           ctl_fail("%s", error);
    if (good)
        dmn_print(stdout, "%s: %dx%d, from no path per pixel (black) to %.4g (bright), log scale\n",
                  ctl->operand[1], map.width, map.height, most);
end:
    free(map.rgb);
    free(map.cover);
    return good;
}

static int run(const struct ctl *ctl)
{
    char error[RND_ERROR_SIZE];
    struct trk_log log = {0};
    float *counts;
    int width, height;
    bool good;

    if (!ctl_is_picture(ctl, ctl->operand[1])) return 2;
    if (ctl->gaze && !trk_log_read(ctl->gaze, &log, error)) return ctl_fail("%s", error), 1;
    counts = rnd_image_read_channel(ctl->operand[0], "samples", &width, &height, error);
    good = counts ? draw(ctl, counts, width, height, ctl->gaze ? &log : NULL) : ctl_fail("%s", error);
    free(counts);
    trk_log_finish(&log);
    return good ? 0 : 1;
}

const struct ctl_command ctl_samples = {
    .name = "samples",
    .operands = "FILE.exr OUT.png",
    .summary = "draw where the samples of a saved file fell",
    .options = "gaze",
    .run = CTL_NEEDS_IMAGES(run),
};
