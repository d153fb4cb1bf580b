/* Print how much two images differ in what they show, whatever their noise: the root mean square difference
 * of the means of their parts, over the mean of both, in thousandths. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "renderer.h"

enum { PARTS = 8 };

static int means(const char *path, double out[PARTS * PARTS])
{
    char error[RND_ERROR_SIZE];
    int width, height;
    float *rgb = rnd_image_read(path, &width, &height, NULL, error);

    if (!rgb) return fprintf(stderr, "%s\n", error), 1;
    for (int i = 0; i < PARTS * PARTS; i++) out[i] = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                out[y * PARTS / height * PARTS + x * PARTS / width] +=
                    rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] * (double)(PARTS * PARTS) /
                    (3.0 * width * height);
    free(rgb);
    return 0;
}

int main(int argc, char **argv)
{
    double one[PARTS * PARTS], other[PARTS * PARTS], square = 0, sum = 0;

    if (argc != 3 || means(argv[1], one) || means(argv[2], other)) return 2;
    for (int i = 0; i < PARTS * PARTS; i++) {
        square += (one[i] - other[i]) * (one[i] - other[i]);
        sum += (one[i] + other[i]) / 2;
    }
    printf("%.0f\n", 1000 * sqrt(square * PARTS * PARTS) / sum);
    return 0;
}
