/* How bright radiance is shown. */
#include "math/sphere.h"
#include "renderer.h"

#include <math.h>
#include <stdlib.h>

/* Middle grey, to which automatic exposure brings the median. */
static const float GREY = 0.18f;

struct block {
    float luminance, weight;
};

static int by_luminance(const void *a, const void *b)
{
    const struct block *p = a, *q = b;
    return (p->luminance > q->luminance) - (p->luminance < q->luminance);
}

/* The gain that brings the median luminance over the sphere to middle grey. The median is that of blocks:
 * half of the pixels of a noisy picture may be nearly black. */
static float automatic_gain(const float *rgb, int width, int height)
{
    enum { BLOCK = 32 };
    const size_t columns = (size_t)(width / BLOCK), count = columns * (size_t)(height / BLOCK);
    struct block *blocks = calloc(count > 0 ? count : 1, sizeof *blocks);
    float half = 0.0f, median = 0.0f;
    if (!blocks) return 1.0f;
    for (size_t b = 0; b < count; b++) {
        const size_t x = b % columns * BLOCK, y = b / columns * BLOCK;
        for (size_t p = 0; p < BLOCK * BLOCK; p++)
            blocks[b].luminance += rnd_luminance(&rgb[3 * ((y + p / BLOCK) * (size_t)width + x + p % BLOCK)]);
        blocks[b].luminance /= BLOCK * BLOCK;
        blocks[b].weight = sinf(((float)y + BLOCK / 2) / (float)height * (float)M_PI);
        half += blocks[b].weight / 2.0f;
    }
    qsort(blocks, count, sizeof *blocks, by_luminance);
    for (size_t i = 0; i < count && half > 0.0f; i++) {
        half -= blocks[i].weight;
        median = blocks[i].luminance;
    }
    free(blocks);
    return median > 0.0f && isfinite(GREY / median) ? GREY / median : 1.0f;
}

void rnd_expose(const struct rnd_exposure *exposure, float *rgb, int width, int height)
{
    const float gain =
        exposure->automatic ? automatic_gain(rgb, width, height) : exp2f((float)exposure->stops);
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++) rgb[i] *= gain;
}
