/* same_channels PICTURE FILE.exr [CHANNEL]...: does a picture that fake_tev holds have the same values as
 * an EXR that fovead saved, in those channels, or in all that the picture has? An EXR may hold half floats:
 * its values then differ by half of a half float's last digit. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "renderer.h"

static bool same(float exact, float stored)
{
    /* 11 binary digits, down to steps of 2^-24. */
    return exact == stored || fabsf(exact - stored) <= fmaxf(0x1p-11f * fabsf(exact), 0x1p-25f);
}

static int compare(const char *channel, const float *values, int width, int height, const char *path)
{
    char error[RND_ERROR_SIZE];
    int saved_width, saved_height;
    float *saved = rnd_image_read_channel(path, channel, &saved_width, &saved_height, error);
    long others = 0;

    if (!saved) return fprintf(stderr, "%s\n", error), 1;
    if (saved_width != width || saved_height != height)
        return fprintf(stderr, "%dx%d, saved as %dx%d\n", width, height, saved_width, saved_height), 1;
    for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
        if (!same(values[i], saved[i]) && ++others == 1)
            fprintf(stderr, "%s of pixel %zu,%zu is %.9g, saved as %.9g\n", channel, i % (size_t)width,
                    i / (size_t)width, (double)values[i], (double)saved[i]);
    free(saved);
    if (others > 0) fprintf(stderr, "%s: %ld pixels differ\n", channel, others);
    return others > 0;
}

int main(int argc, char **argv)
{
    FILE *file = argc > 2 ? fopen(argv[1], "r") : NULL;
    char channel[64][64];
    int width, height, channels, compared = 0, status = 0;
    size_t pixels;
    float *values;

    if (!file || fscanf(file, "%d %d %d\n", &width, &height, &channels) != 3 || channels > 64) return 2;
    for (int i = 0; i < channels; i++)
        if (fscanf(file, "%63[^\n]", channel[i]) != 1 || fgetc(file) != '\n') return 2;
    pixels = (size_t)width * (size_t)height;
    values = malloc(pixels * sizeof(*values));
    for (int i = 0; i < channels; i++) {
        bool wanted = argc == 3;

        if (!values || fread(values, sizeof(*values), pixels, file) != pixels) return 2;
        for (int k = 3; k < argc; k++) wanted |= !strcmp(argv[k], channel[i]);
        if (!wanted) continue;
        status |= compare(channel[i], values, width, height, argv[2]);
        compared++;
    }
    free(values);
    fclose(file);
    return status || compared < (argc > 3 ? argc - 3 : 1);
}
