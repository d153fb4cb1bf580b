/* Judging tiles: how wrong a tile still is, and whether an eye would see it. */
#include "film/converge.h"
#include "math/sphere.h"
#include "math/uv.h"

#include <stdlib.h>

/* The difference of two halves is one draw per pixel, so that errors are taken over blocks of pixels and at
 * two judgements in a row, and a tile is not called good while one of its pixels has few paths. */
enum { LEAST_PATHS = 16, LEAST_PIXELS = 16 };

/* One in so many blocks of a tile may be worse than the tile's error. */
enum { WORSE_BLOCKS = 20, WORSE = RND_TILE_BLOCKS / WORSE_BLOCKS };

/* Share of the picture whose tiles may have a coarser grain than film->grain. */
#define COARSER 0.1f

/* Luminance, as a share of the picture's brightness, below which an error is relative to this share of the
 * brightness: where it is much darker than elsewhere, an eye that has adapted to the picture sees less. */
#define DARK 0.01f

/* With a probability of 95 % what has not been found in N trials has a share of less than 3 / N (the rule of
 * three: Hanley and Lippman-Hand 1983). */
#define RULE_OF_THREE 3.0f

/* The largest few of up to RND_TILE_BLOCKS values. */
struct largest {
    int count; /* of all values */
    float value[WORSE + 1];
};

static void largest_add(struct largest *largest, float value)
{
    largest->count++;
    for (int i = 0; i <= WORSE; i++)
        if (largest->count <= i + 1 || value > largest->value[i]) {
            const float next = largest->value[i];
            largest->value[i] = value;
            value = next;
        }
}

/* What one value in WORSE_BLOCKS exceeds; 0 of none. */
static float largest_but_few(const struct largest *largest)
{
    return largest->count > 0 ? largest->value[largest->count / WORSE_BLOCKS] : 0.0f;
}

struct block {
    uint32_t visited, judged,
        least;                  /* pixels with paths, with paths in both halves; fewest paths of a pixel */
    bool black;                 /* a pixel has paths, and all of them found nothing */
    double paths, light;        /* sums over pixels: paths, mean luminance */
    double square, spread, lit; /* over the judged ones: squared error, variance of a path, luminance */
};

static void add_up(const struct rnd_film_tile *tile, uint32_t index, struct block *out)
{
    const struct rnd_film_pixels *pixels = tile->pixels;
    const uint32_t side = RND_TILE / RND_BLOCK;
    const uint32_t first = index / side * RND_BLOCK * RND_TILE + index % side * RND_BLOCK;
    *out = (struct block){.least = UINT32_MAX};
    for (uint32_t k = 0; k < RND_BLOCK * RND_BLOCK; k++) {
        const uint32_t i = first + k / RND_BLOCK * RND_TILE + k % RND_BLOCK;
        const struct rnd_film_pixel *pixel = &pixels->pixel[i];
        const uint32_t even = pixel->count[0], odd = pixel->count[1], n = even + odd;
        out->least = n < out->least ? n : out->least;
        if (n == 0) continue;
        const double a = rnd_luminance(pixel->half[0]), b = rnd_luminance(pixel->half[1]),
                     mean = (even * a + odd * b) / n;
        out->visited++;
        out->paths += n;
        out->light += mean;
        out->black |= mean <= 0.0;
        if (odd == 0 || even == 0) continue;
        const double d = a - b;
        out->judged++;
        out->square += 0.25 * d * d;
        out->spread += 0.25 * d * d * n;
        out->lit += mean;
    }
}

/* Relative standard error of a block's pixels. Where a pixel found nothing, there may be light that no path
 * has met so far: as much as is just likely, of paths that each bring what paths bring elsewhere in the
 * picture. */
static float block_error(const struct rnd_film *film, const struct block *block)
{
    const double mean = block->light / block->visited;
    const double error = sqrt(block->square / block->judged) / fmax(mean, DARK * film->brightness);
    if (!block->black) return (float)error;
    if (film->brightness <= 0.0f) return INFINITY;
    return (float)fmax(error, RULE_OF_THREE * film->grain / (block->paths * film->brightness));
}

void rnd_judge(const struct rnd_film *film, struct rnd_film_tile *tile)
{
    struct largest error = {0}, grain = {0};
    double light = 0.0;
    uint32_t visited = 0, least = UINT32_MAX;
    for (uint32_t i = 0; i < RND_TILE_BLOCKS; i++) {
        struct block block;
        add_up(tile, i, &block);
        light += block.light;
        visited += block.visited;
        least = block.least < least ? block.least : least;
        if (block.judged < LEAST_PIXELS) continue;
        largest_add(&error, block_error(film, &block));
        if (block.lit > 0.0) largest_add(&grain, (float)(block.spread / block.lit));
    }
    if (error.count == 0) return;
    tile->state.luminance = (float)(light / visited);
    tile->grain = largest_but_few(&grain);
    const float now = largest_but_few(&error), sure = least >= LEAST_PATHS ? now : INFINITY;
    tile->state.error = now;
    tile->state.sure_error = fmaxf(sure, tile->former_error);
    tile->state.converged = tile->state.sure_error <= film->error_bar;
    tile->former_error = sure;
}

/* --- the picture as a whole --- */

static int ascending(const void *a, const void *b)
{
    const struct rnd_weighed *p = a, *q = b;
    return (p->value > q->value) - (p->value < q->value);
}

/* The value below which that share of the weight lies; 0 of none. */
static float quantile(struct rnd_weighed *list, size_t count, float share)
{
    double sum = 0.0, below = 0.0;
    qsort(list, count, sizeof *list, ascending);
    for (size_t i = 0; i < count; i++) sum += list[i].weight;
    for (size_t i = 0; i < count; i++)
        if ((below += list[i].weight) >= share * sum) return list[i].value;
    return 0.0f;
}

void rnd_film_survey(struct rnd_film *film)
{
    const int tiles = film->across * film->down;
    struct rnd_weighed *list = film->weighed;
    double light = 0.0, weights = 0.0;
    size_t judged = 0, lit = 0;
    film->next_survey = film->paths + film->paths / 4 + 16 * (uint64_t)tiles; /* so that it costs little */
    for (int t = 0; t < tiles; t++) {
        const struct rnd_film_tile *tile = &film->tile[t];
        const float weight = rnd_row_weight(t / film->across, film->down);
        if (tile->grain < 0.0f) continue;
        list[judged++] = (struct rnd_weighed){tile->state.luminance, weight};
        light += (double)weight * tile->state.luminance;
        weights += weight;
    }
    if (judged == 0) return;
    film->brightness = quantile(list, judged, 0.5f);
    if (film->brightness <= 0.0f) film->brightness = (float)(light / weights); /* most of it is black */
    for (int t = 0; t < tiles; t++) {
        const struct rnd_film_tile *tile = &film->tile[t];
        const float weight = rnd_row_weight(t / film->across, film->down);
        if (tile->grain >= 0.0f && tile->state.luminance > 0.0f)
            list[lit++] = (struct rnd_weighed){tile->grain, weight};
    }
    film->grain = quantile(list, lit, 1.0f - COARSER);
}

/* --- what an eye sees --- */

float rnd_visible_error(float eccentricity_deg, float pixels_per_degree)
{
    const float k = 0.106f * (eccentricity_deg + 2.3f) / 2.3f;
    const float f = fminf(1.0f / k, 0.5f * pixels_per_degree); /* where f exp(-k f) is greatest */
    return 0.5f * pixels_per_degree / (64.0f * sqrtf(1.5f * (float)M_PI) * f * expf(-k * f));
}

float rnd_visible_flicker(float eccentricity_deg, float pixels_per_degree)
{
    /* Thresholds at 20 pixels per degree, where the noise is white. Its contrast in an octave falls as the
     * pixels get smaller. */
    static const float TABLE[][2] = {{0.0f, 0.021f},  {5.0f, 0.035f},  {10.0f, 0.046f}, {20.0f, 0.064f},
                                     {30.0f, 0.080f}, {40.0f, 0.095f}, {55.0f, 0.118f}};
    enum { ROWS = sizeof TABLE / sizeof *TABLE };
    int i = 1;
    while (i < ROWS - 1 && TABLE[i][0] < eccentricity_deg) i++;
    const float *from = TABLE[i - 1], *to = TABLE[i],
                share = fminf(1.0f, (eccentricity_deg - from[0]) / (to[0] - from[0]));
    return 0.5f * (from[1] + share * (to[1] - from[1])) * pixels_per_degree / 20.0f;
}

float rnd_tile_cosine(const struct rnd_film *film, int x, int y, const float gaze[3])
{
    float u, v;
    rnd_v3_to_uv(rnd_v3(gaze[0], gaze[1], gaze[2]), &u, &v);
    const float half = 0.5f / (float)film->across, top = (float)y / (float)film->down,
                bottom = (float)(y + 1) / (float)film->down;
    float turn = u - ((float)x + 0.5f) / (float)film->across; /* from its middle meridian */
    turn = fabsf(turn - roundf(turn));
    /* On a parallel, the point nearest in azimuth is nearest. If the gaze's meridian crosses the tile, the
     * nearest point lies on it. */
    if (turn <= half) return cosf((float)M_PI * fmaxf(0.0f, fmaxf(top - v, v - bottom)));
    /* Otherwise it lies on the nearer edge, a half circle: project the gaze onto the plane of that half
     * circle. */
    const float beside = 2.0f * (float)M_PI * (turn - half), low = (float)M_PI * (0.5f - bottom),
                high = (float)M_PI * (0.5f - top);
    vec2 at = {sqrtf(gaze[0] * gaze[0] + gaze[2] * gaze[2]) * cosf(beside), gaze[1]},
         lowest = {cosf(low), sinf(low)}, highest = {cosf(high), sinf(high)};
    if (glm_vec2_cross(lowest, at) >= 0.0f && glm_vec2_cross(at, highest) >= 0.0f) return glm_vec2_norm(at);
    return fmaxf(glm_vec2_dot(lowest, at), glm_vec2_dot(highest, at));
}

bool rnd_film_settled(const struct rnd_film *film, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3])
{
    if (tile->unvisited > 0 || tile->samples == 0 || isinf(tile->sure_error)) return false;
    const float cosine = rnd_tile_cosine(film, x, y, gaze);
    const float eccentricity_deg = glm_deg(acosf(fmaxf(-1.0f, fminf(1.0f, cosine))));
    return tile->sure_error <= rnd_visible_error(eccentricity_deg, (float)film->width / 360.0f);
}
