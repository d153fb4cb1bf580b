/* golden FILE.exr PICTURE.png: make a golden image of a panorama that fovead saved, from the part ahead of
 * the camera: 90 degrees left and right, 45 up and down. x / (1 + x) brings all radiance below 1, so that
 * emitters of different brightness differ in 8 bits, and a rare bright path does not make a white spot. */
#include <stdio.h>
#include <stdlib.h>

#include "image.h"

int main(int argc, char **argv)
{
    char error[RND_ERROR_SIZE];
    int width, height;
    float *rgb;
    size_t kept = 0;

    if (argc != 3) return 2;
    rgb = rnd_image_read(argv[1], &width, &height, NULL, error);
    if (!rgb) return fprintf(stderr, "%s\n", error), 1;
    for (int y = height / 4; y < height / 4 + height / 2; y++)
        for (int x = width / 4; x < width / 4 + width / 2; x++)
            for (int c = 0; c < 3; c++) {
                float light = rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c];

                rgb[kept++] = light / (1 + light);
            }
    if (!dmn_image_write(argv[2], 0666, width / 2, height / 2, rgb, false, error))
        return fprintf(stderr, "%s\n", error), 1;
    free(rgb);
    return 0;
}
