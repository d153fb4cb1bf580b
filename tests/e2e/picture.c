/* picture FILE WIDTH HEIGHT [FILM.exr]: check that an image has this size, is finite, and has light in every
 * part. Prints its mean in thousandths. If the film that the daemon saved is given, at most one pixel in
 * 100,000 may be black in tiles with more paths than the outline gives them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "renderer.h"

enum { PARTS = 8, OUTLINE_PATHS = 16 };

/* Count the pixels that are black or not finite in tiles with more paths than the outline's. */
static long dark_pixels(const float *rgb, const float *samples, int width, int height, long *out_tiles)
{
    long dark = 0;

    *out_tiles = 0;
    for (int top = 0; top < height; top += RND_TILE)
        for (int left = 0; left < width; left += RND_TILE) {
            double paths = 0;
            long here = 0;

            for (int i = 0; i < RND_TILE * RND_TILE; i++) {
                size_t at = (size_t)(top + i / RND_TILE) * (size_t)width + (size_t)(left + i % RND_TILE);

                paths += samples[at];
                here += !(rgb[3 * at] + rgb[3 * at + 1] + rgb[3 * at + 2] > 0);
            }
            if (paths <= OUTLINE_PATHS) continue;
            ++*out_tiles;
            dark += here;
        }
    return dark;
}

int main(int argc, char **argv)
{
    char error[RND_ERROR_SIZE];
    double sum[PARTS][PARTS] = {{0}}, all = 0;
    int width, height;
    float *rgb;

    if (argc != 4 && argc != 5) return 2;
    rgb = rnd_image_read(argv[1], &width, &height, NULL, error);
    if (!rgb) return fprintf(stderr, "%s\n", error), 1;
    if (width != atoi(argv[2]) || height != atoi(argv[3]))
        return fprintf(stderr, "%s: %dx%d\n", argv[1], width, height), 1;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                sum[y * PARTS / height][x * PARTS / width] +=
                    rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c];
    if (argc == 5) {
        float *samples = rnd_image_read_channel(argv[4], "samples", &width, &height, error);
        long tiles, dark;

        if (!samples) return fprintf(stderr, "%s\n", error), 1;
        dark = dark_pixels(rgb, samples, width, height, &tiles);
        printf("%ld visited tiles, %ld black or not finite pixels in them\n", tiles, dark);
        free(samples);
        /* A few pixels are really black. */
        if (tiles == 0 || dark * 100000 > tiles * RND_TILE * RND_TILE) return 1;
    }
    free(rgb);
    for (int y = 0; y < PARTS; y++)
        for (int x = 0; x < PARTS; x++) {
            all += sum[y][x];
            if (!isfinite(sum[y][x]) || sum[y][x] <= 0)
                return fprintf(stderr, "%s: part %d,%d of %d is black or not finite\n", argv[1], x, y, PARTS),
                       1;
        }
    printf("%.0f\n", 1000 * all / (3.0 * width * height));
    return 0;
}
