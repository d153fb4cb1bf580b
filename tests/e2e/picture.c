/* Is this an image of that size, finite, with something in every part of it? Prints its mean in thousandths.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "renderer.h"

enum { PARTS = 8 };

int main(int argc, char **argv)
{
    char error[RND_ERROR_SIZE];
    double sum[PARTS][PARTS] = {{0}}, all = 0;
    int width, height;
    float *rgb;

    if (argc != 4) return 2;
    rgb = rnd_image_read(argv[1], &width, &height, error);
    if (!rgb) return fprintf(stderr, "%s\n", error), 1;
    if (width != atoi(argv[2]) || height != atoi(argv[3]))
        return fprintf(stderr, "%s: %dx%d\n", argv[1], width, height), 1;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                sum[y * PARTS / height][x * PARTS / width] +=
                    rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c];
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
