/* mean FILE [LEFT TOP RIGHT BOTTOM]: print the mean of an image's three channels over a part of it, whose
 * borders are shares of its width and height; over all of it if none are given. mean FILE CHANNEL: print that
 * of one channel. Pixels that are not finite are an error. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "renderer.h"

int main(int argc, char **argv)
{
    char error[RND_ERROR_SIZE];
    double part[4] = {0, 0, 1, 1}, sum = 0;
    size_t channels = argc == 3 ? 1 : 3;
    long count = 0;
    int width, height;
    float *values;

    if (argc != 2 && argc != 3 && argc != 6) return 2;
    for (int i = 2; i < argc && argc == 6; i++) part[i - 2] = atof(argv[i]);
    values = argc == 3 ? rnd_image_read_channel(argv[1], argv[2], &width, &height, error)
                       : rnd_image_read(argv[1], &width, &height, NULL, error);
    if (!values) return fprintf(stderr, "%s\n", error), 1;
    for (int y = (int)(part[1] * height); y < (int)ceil(part[3] * height); y++)
        for (int x = (int)(part[0] * width); x < (int)ceil(part[2] * width); x++)
            for (size_t c = 0; c < channels; c++, count++)
                sum += (double)values[channels * ((size_t)y * (size_t)width + (size_t)x) + c];
    free(values);
    if (count == 0 || !isfinite(sum)) return fprintf(stderr, "%s: no finite mean\n", argv[1]), 1;
    printf("%.6g\n", sum / (double)count);
    return 0;
}
