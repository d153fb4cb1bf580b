/* Does a client have exactly what the daemon has? e2e_exact SNAPSHOT SAVED: an EXR of foveactl snapshot and
 * one of foveactl save, of the same film. Compares the tiles ahead, within 50 degrees of the middle of the
 * picture. Exit status: 0 their radiance is the same bit for bit, as half floats; 1 it is not; 2 an error; 3
 * some of their pixels have no path or no light yet, so that a client sees a reconstruction and not their
 * means. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol.h"
#include "renderer.h"

enum { VALUES = RND_TILE * RND_TILE * 3 };

static const float *tile_of(const float *film, int width, int channels, int x, int y, float *out)
{
    for (int row = 0; row < RND_TILE; row++)
        memcpy(out + row * RND_TILE * channels,
               film +
                   ((size_t)(y * RND_TILE + row) * (size_t)width + (size_t)(x * RND_TILE)) * (size_t)channels,
               sizeof(float) * (size_t)(RND_TILE * channels));
    return out;
}

static bool is_whole(const float *rgb, const float *samples)
{
    for (int i = 0; i < RND_TILE * RND_TILE; i++)
        if (samples[i] < 1 || rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2] <= 0) return false;
    return true;
}

/* Is the one, as a tile of half floats carries it, the other? */
static bool is_same(const float *saved, const float *shown)
{
    float carried[VALUES];
    size_t count;
    uint8_t *bytes = pro_encode(FOVEA__ENCODING__ENCODING_HALF_ZSTD, saved, RND_TILE, &count);
    bool same = bytes && pro_decode(FOVEA__ENCODING__ENCODING_HALF_ZSTD, bytes, count, RND_TILE, carried) &&
                memcmp(carried, shown, sizeof(carried)) == 0;

    free(bytes);
    return same;
}

int main(int argc, char **argv)
{
    char error[RND_ERROR_SIZE] = "usage: e2e_exact SNAPSHOT SAVED";
    int width, height, other_width, other_height, tiles = 0, differ = 0;
    float *shown = argc == 3 ? rnd_image_read(argv[1], &width, &height, NULL, error) : NULL;
    float *saved = shown ? rnd_image_read(argv[2], &other_width, &other_height, NULL, error) : NULL;
    float *samples =
        saved ? rnd_image_read_channel(argv[2], "samples", &other_width, &other_height, error) : NULL;
    static float one[VALUES], other[VALUES], counts[RND_TILE * RND_TILE];
    bool whole = true;

    if (!samples) return fprintf(stderr, "%s\n", error), 2;
    if (width != other_width || height != other_height) return fprintf(stderr, "two films\n"), 2;
    for (int y = 0; y < height / RND_TILE; y++)
        for (int x = 0; x < width / RND_TILE; x++) {
            float middle[3];

            rnd_direction(((x + 0.5f) * RND_TILE / width * 2 - 1) * (float)M_PI,
                          (0.5f - (y + 0.5f) * RND_TILE / height) * (float)M_PI, middle);
            if (-middle[2] < cosf(50 * (float)M_PI / 180)) continue;
            tile_of(saved, width, 3, x, y, one);
            whole &= is_whole(one, tile_of(samples, width, 1, x, y, counts));
            differ += !is_same(one, tile_of(shown, width, 3, x, y, other));
            tiles++;
        }
    printf("%d tiles, %d of them differ\n", tiles, differ);
    free(shown);
    free(saved);
    free(samples);
    if (tiles < 4) return 2;
    return !whole ? 3 : differ ? 1 : 0;
}
