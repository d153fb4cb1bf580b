/* Judging tiles: how wrong a tile still is, and whether an eye would see it. */
#include "film.h"
#include "path/uv.h"
#include "render.h"
#include "sphere.h"

/* Half-buffer error is one draw a pixel, so a tile is judged by many pixels and twice in a row, and never
 * while a pixel has few paths: what stops early by luck stays wrong for ever. */
enum { LEAST_PIXELS = 64, LEAST_PATHS = 16 };

/* Luminance below which the error is absolute: a black tile is not judged by its own darkness. */
#define DARK 1e-3f

void rnd_judge(struct rnd_film_tile *tile, float error_bar)
{
    const struct rnd_film_pixels *pixels = tile->pixels;
    double square = 0.0, light = 0.0;
    uint32_t judged = 0, visited = 0, least = UINT32_MAX;
    for (int i = 0; i < RND_TILE_PIXELS; i++) {
        const uint32_t even = pixels->count[0][i], odd = pixels->count[1][i], n = even + odd;
        least = n < least ? n : least;
        if (n == 0) continue;
        const float a = even ? rnd_luminance(pixels->half[0][i]) : 0.0f,
                    b = odd ? rnd_luminance(pixels->half[1][i]) : 0.0f;
        light += (a + b) / n;
        visited++;
        if (odd == 0 || even == 0) continue;
        const double d = a / even - b / odd;
        square += 0.25 * d * d;
        judged++;
    }
    if (judged < LEAST_PIXELS) return;
    tile->state.luminance = (float)(light / visited);
    tile->state.error = (float)sqrt(square / judged) / fmaxf(tile->state.luminance, DARK);
    const bool below = tile->state.error <= error_bar && least >= LEAST_PATHS;
    tile->state.converged = below && tile->passed;
    tile->passed = below;
}

float rnd_visible_error(float eccentricity_deg, float pixels_per_degree)
{
    const float k = 0.106f * (eccentricity_deg + 2.3f) / 2.3f;
    const float f = fminf(1.0f / k, 0.5f * pixels_per_degree); /* where f exp(-k f) is greatest */
    return 0.5f * pixels_per_degree / (64.0f * sqrtf(1.5f * (float)M_PI) * f * expf(-k * f));
}

bool rnd_tile_settled(const struct rnd_render *render, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3])
{
    if (tile->unvisited > 0 || tile->samples == 0) return false;
    const float step_u = 1.0f / (float)render->film.across, step_v = 1.0f / (float)render->film.down;
    /* The nearest of the tile's centre and corners to the gaze. Cells are chosen by this, many in a batch:
     * where the error would be seen at the centre already, it would be nearer by. */
    static const float place[5][2] = {{0.5f, 0.5f}, {0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const float ppd = (float)render->film.width / 360.0f;
    float nearest = 5.0f; /* square of the chord, at most 4 */
    for (int i = 0; i < 5; i++) {
        const struct rnd_v3 d =
            rnd_v3_from_uv(((float)x + place[i][0]) * step_u, ((float)y + place[i][1]) * step_v);
        const struct rnd_v3 chord = rnd_v3_sub(d, rnd_v3(gaze[0], gaze[1], gaze[2]));
        const float square = rnd_v3_dot(chord, chord);
        if (square >= nearest) continue;
        nearest = square;
        if (tile->error > rnd_visible_error(glm_deg(2.0f * asinf(0.5f * sqrtf(nearest))), ppd)) return false;
    }
    return true;
}
