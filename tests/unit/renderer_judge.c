/* What is said about a film and what is shown of it. The films' paths are made up, so that the truth is
 * known. */
#include "renderer_files.h"

#include "film/converge.h"
#include "film/film.h"
#include "render.h"
#include "math/sphere.h"

enum { SIDE = RND_TILE, COUNT = RND_TILE_PIXELS, TILE_PATHS = 2 };

/* --- films of made-up paths --- */

static uint32_t random_bits(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*state >> 33);
}

static double random_unit(uint64_t *state)
{
    return random_bits(state) / 2147483648.0;
}

/* The contribution of one path through the pixel (x, y) of the film. */
typedef double (*world)(int x, int y, uint64_t *random);

/* Add rounds times TILE_PATHS paths to every pixel. */
static void add_rounds(struct rnd_film *film, world look, double scale, int rounds, uint64_t *random)
{
    static struct rnd_sample samples[TILE_PATHS * COUNT];
    static const struct rnd_aim aim;
    const int tiles = film->across * film->down;
    for (int r = 0; r < rounds; r++) {
        for (int t = 0; t < tiles; t++) {
            struct rnd_film_tile *tile = &film->tile[t];
            for (uint32_t i = 0; i < TILE_PATHS * COUNT; i++) {
                const uint32_t pixel = i % COUNT;
                const int x = t % film->across * SIDE + (int)pixel % SIDE,
                          y = t / film->across * SIDE + (int)pixel / SIDE;
                const float value = (float)(scale * look(x, y, random));
                samples[i] = (struct rnd_sample){pixel, rnd_film_draw(tile, pixel), {value, value, value}};
            }
            rnd_film_add(film, tile, samples, NULL, TILE_PATHS * COUNT, &aim, 1);
            film->paths += TILE_PATHS * COUNT;
        }
        if (film->paths >= film->next_survey) rnd_film_survey(film);
    }
}

static void begin(struct rnd_render *render, int width)
{
    static const struct rnd_camera camera;
    *render = (struct rnd_render){0};
    assert_true(rnd_film_init(&render->film, width, width / 2, 0.05f, 0, &camera));
    assert_true(
        rnd_reconstructor_init(&render->reconstructor, rnd_reconstruction_at(0), &render->film, NULL));
}

/* Returns how many rounds it takes until a whole film of this width is converged, `most` at the most. */
static int rounds_to_converge(int width, world look, double scale, int most, struct rnd_tile *out_first)
{
    struct rnd_render render;
    uint64_t random = 1;
    int rounds = 0;
    begin(&render, width);
    for (bool done = false; !done && rounds < most; rounds++) {
        add_rounds(&render.film, look, scale, 1, &random);
        done = true;
        for (int t = 0; t < render.film.across * render.film.down; t++)
            done = done && render.film.tile[t].state.converged;
    }
    *out_first = render.film.tile[0].state;
    rnd_film_finish(&render.film);
    return rounds;
}

/* --- judging --- */

static double nothing(int x, int y, uint64_t *random)
{
    (void)x, (void)y, (void)random;
    return 0;
}

/* Light that one path in about ten thousand finds, and nothing else. */
static double rare(int x, int y, uint64_t *random)
{
    (void)x, (void)y;
    return random_unit(random) < 1e-4 ? 1e4 : 0;
}

/* A grey wall with little noise. */
static double calm(int x, int y, uint64_t *random)
{
    (void)x, (void)y;
    return 0.5 + 0.4 * random_unit(random);
}

/* The wall, and the right half of the film is black like a sky without stars. */
static double half_black(int x, int y, uint64_t *random)
{
    return x >= SIDE ? 0 : calm(x, y, random);
}

/* The wall, and the right half is lit by rare light. */
static double half_rare(int x, int y, uint64_t *random)
{
    return x >= SIDE ? rare(x, y, random) : calm(x, y, random);
}

/* A noisy wall, and an emitter of radiance 1000 without noise in a hundredth of the tile. */
static double emitter_and_noise(int x, int y, uint64_t *random)
{
    if (x % SIDE < 8 && y < 5) return 1000;
    return random_unit(random) < 0.1 ? 10 : 0;
}

static void no_news(void **state)
{
    (void)state;
    struct rnd_tile tile;
    assert_int_equal(rounds_to_converge(128, nothing, 1, 100, &tile), 100);
    assert_true(isinf(tile.sure_error) && isinf(tile.error));
    /* black at first; then each round finds about 0.8 bright pixels per tile */
    assert_int_equal(rounds_to_converge(128, rare, 1, 100, &tile), 100);
    assert_true(tile.sure_error > 0.5f);
    print_message("found by one path in 10,000: error %.2f after 200 paths per pixel\n", (double)tile.error);
}

/* Pixels that stay black do not keep a tile from converging. Pixels that are black only by chance do. */
static void black_beside_light(void **state)
{
    (void)state;
    struct rnd_tile tile;
    const int light = rounds_to_converge(128, calm, 1, 200, &tile),
              black = rounds_to_converge(128, half_black, 1, 200, &tile);
    print_message("converged after %d paths per pixel, beside black after %d\n", TILE_PATHS * light,
                  TILE_PATHS * black);
    assert_true(light < 200 && black <= 4 * light);
    assert_int_equal(rounds_to_converge(128, half_rare, 1, 100, &tile), 100);
}

static void bright_hides_nothing(void **state)
{
    (void)state;
    struct rnd_render render;
    uint64_t random = 5;
    begin(&render, 128);
    add_rounds(&render.film, emitter_and_noise, 1, 13, &random);
    /* 26 paths, a tenth of which contribute 10: relative variance 9 / 26 */
    const struct rnd_tile *tile = &render.film.tile[0].state;
    print_message("error %.3f, that of the wall is %.3f\n", (double)tile->error, sqrt(9.0 / 26));
    assert_false(tile->converged);
    assert_true(tile->error > 0.9 * sqrt(9.0 / 26) && tile->error < 1.6 * sqrt(9.0 / 26));
    rnd_film_finish(&render.film);
}

/* The same world in other units is judged in the same way. */
static void units(void **state)
{
    (void)state;
    static const double scale[] = {1, 1e-5, 1e-10, 1e6};
    struct rnd_tile tile[4];
    int rounds[4];
    for (int k = 0; k < 4; k++) {
        rounds[k] = rounds_to_converge(128, half_black, scale[k], 200, &tile[k]);
        print_message("light times %g: %d paths per pixel, error %.4f\n", scale[k], TILE_PATHS * rounds[k],
                      (double)tile[k].error);
        assert_int_equal(rounds[k], rounds[0]);
        assert_float_equal(tile[k].error, tile[0].error, 1e-3 * tile[0].error);
    }
    assert_true(rounds[0] < 200 && rounds[0] * TILE_PATHS >= 16);
}

/* --- sums --- */

/* With 131,072 paths of 0.3 in each pixel of a block, the mean is still exact at every level. */
static void many_paths(void **state)
{
    (void)state;
    enum { PATHS = 1 << 17, CHUNK = 1 << 12 };
    static struct rnd_sample samples[CHUNK];
    static float rgb[COUNT * 3];
    static const struct rnd_aim aim;
    struct rnd_render render;
    begin(&render, 1024);
    struct rnd_film_tile *tile = &render.film.tile[0];
    for (uint32_t first = 0; first < 64u * PATHS; first += CHUNK) {
        for (uint32_t i = 0; i < CHUNK; i++) {
            const uint32_t k = i % 64, pixel = k / 8 * SIDE + k % 8;
            samples[i] = (struct rnd_sample){pixel, (first + i) / 64, {0.3f, 0.3f, 0.3f}};
        }
        rnd_film_add(&render.film, tile, samples, NULL, CHUNK, &aim, 1);
    }
    for (int level = 0; level < 4; level++) {
        assert_true(rnd_render_read(&render, level, 0, 0, rgb, NULL));
        for (int c = 0; c < 3; c++) assert_float_equal(rgb[c], 0.3f, 1e-5f);
    }
    assert_int_equal(tile->state.samples, 64u * PATHS);
    rnd_film_finish(&render.film);
}

/* In each 8 x 8, 16 x 16 and 64 x 64 pixels, the dark half has eight times as many paths, and still counts as
 * one half. */
static void area_counts(void **state)
{
    (void)state;
    static struct rnd_sample samples[COUNT * 8];
    static float rgb[COUNT * 3];
    static const struct rnd_aim aim;
    static const int stripe[] = {4, 8, 32};
    for (int s = 0; s < 3; s++) {
        struct rnd_render render;
        begin(&render, 1024);
        const int tiles = render.film.across * render.film.down;
        for (int t = 0; t < tiles; t++) {
            uint32_t n = 0;
            for (uint32_t i = 0; i < COUNT; i++) {
                const bool dark = i % SIDE / (uint32_t)stripe[s] % 2;
                for (uint32_t k = 0; k < (dark ? 8 : 1); k++)
                    samples[n++] = (struct rnd_sample){i, k, {!dark, !dark, !dark}};
            }
            rnd_film_add(&render.film, &render.film.tile[t], samples, NULL, n, &aim, 1);
        }
        for (int level = 0; level < 4; level++) {
            double mean = 0;
            assert_true(rnd_render_read(&render, level, 0, 0, rgb, NULL));
            for (int i = 0; i < COUNT; i++) mean += rgb[3 * i] / COUNT;
            assert_float_equal(mean, 0.5, 1e-5);
            for (int i = 0; i < COUNT && 1 << level >= 2 * stripe[s]; i++)
                assert_float_equal(rgb[3 * i], 0.5, 1e-5);
        }
        rnd_film_finish(&render.film);
    }
}

/* --- what is shown --- */

static bool pull_push(const struct rnd_sums *sums, float *out)
{
    const struct rnd_window window = {.side = SIDE, .pixel = sums->pixel};
    return rnd_reconstruction_pull_push.run(NULL, &window, out);
}

static void show(const struct rnd_sums *sums, float *out, double *out_mean)
{
    assert_true(pull_push(sums, out));
    *out_mean = 0;
    for (int i = 0; i < 3 * COUNT; i++) {
        assert_true(isfinite(out[i]) && out[i] >= 0.0f);
        *out_mean += out[i] / (3.0 * COUNT);
    }
}

static void set(struct rnd_sums *sums, int i, float light, float paths, float hits)
{
    sums->pixel[i] = (struct rnd_sum){{light, 2 * light, 0}, 1, paths, hits};
}

static void shown(void **state)
{
    (void)state;
    static struct rnd_sums sums;
    static float rgb[COUNT * 3];
    double mean;
    memset(&sums, 0, sizeof sums);
    assert_false(pull_push(&sums, rgb));
    set(&sums, 700, 3, 1, 1); /* a single path is shown everywhere */
    show(&sums, rgb, &mean);
    for (int i = 0; i < COUNT; i++)
        assert_true(rgb[3 * i] == 3 && rgb[3 * i + 1] == 6 && rgb[3 * i + 2] == 0);

    /* pixels that have found light show it unchanged */
    for (int i = 0; i < COUNT; i++) set(&sums, i, 1 + (float)(i * 37 % 101), 1, 1);
    show(&sums, rgb, &mean);
    for (int i = 0; i < COUNT; i++) assert_float_equal(rgb[3 * i], (1 + i * 37 % 101), 1e-4);
    sums.pixel[0] = (struct rnd_sum){0}; /* a pixel without a path shows the mean of its three neighbours */
    show(&sums, rgb, &mean);
    assert_float_equal(rgb[0], (rgb[3] + rgb[3 * SIDE] + rgb[3 * SIDE + 3]) / 3, 1e-4);
    assert_float_equal(rgb[3], 38, 1e-4);

    /* one hit among many paths that found nothing is spread over all of them */
    for (int i = 0; i < COUNT; i++) set(&sums, i, 0, 4, 0);
    set(&sums, 700, 4096, 4, 1);
    show(&sums, rgb, &mean);
    for (int i = 0; i < COUNT; i++) assert_float_equal(rgb[3 * i], 1, 1e-4);

    /* with many paths a black pixel stays black, and its bright neighbours keep their values */
    for (int i = 0; i < COUNT; i++) set(&sums, i, i % 3 ? 2 : 0, 1000, i % 3 ? 900 : 0);
    show(&sums, rgb, &mean);
    for (int i = 0; i < COUNT; i++) assert_float_equal(rgb[3 * i], (i % 3 ? 2 : 0), 1e-5);
}

/* Rare light is shown with its brightness from the first path on. */
static void rare_light_shown(void **state)
{
    (void)state;
    static float rgb[COUNT * 3];
    static double found[2 * SIDE * SIDE];
    static const double share[] = {0.3, 0.03, 0.001};
    for (int k = 0; k < 3; k++) {
        struct rnd_render render;
        uint64_t random = 11;
        static const struct rnd_aim aim;
        begin(&render, 128);
        memset(found, 0, sizeof found);
        for (int paths = 1; paths <= 128; paths++) {
            double seen = 0, true_mean = 0;
            for (int t = 0; t < 2; t++) {
                static struct rnd_sample samples[COUNT];
                for (uint32_t i = 0; i < COUNT; i++) {
                    const float v = random_unit(&random) < share[k] ? (float)(1 / share[k]) : 0;
                    samples[i] = (struct rnd_sample){i, (uint32_t)paths - 1, {v, v, v}};
                    found[(uint32_t)t * COUNT + i] += v;
                }
                rnd_film_add(&render.film, &render.film.tile[t], samples, NULL, COUNT, &aim, 1);
                assert_true(rnd_render_read(&render, 0, t, 0, rgb, NULL));
                for (int i = 0; i < COUNT; i++) {
                    assert_true(rgb[3 * i] >= 0.0f);
                    seen += rgb[3 * i];
                    true_mean += found[t * COUNT + i] / paths;
                }
            }
            assert_float_equal(seen, true_mean, 1e-3 * true_mean);
            if (paths == 1 || paths == 4 || paths == 16 || paths == 64)
                print_message("light of %g of the paths, %d per pixel: %.4f of it is shown\n", share[k],
                              paths, seen / true_mean);
        }
        rnd_film_finish(&render.film);
    }
}

/* --- eccentricity --- */

/* Cosine of the angle to the nearest of many points of the tile. */
static double cosine_by_points(const struct rnd_film *film, int x, int y, const float gaze[3])
{
    enum { POINTS = 48 };
    double best = -1;
    for (int i = 0; i <= POINTS; i++)
        for (int k = 0; k <= POINTS; k++) {
            const double u = (x + (double)i / POINTS) / film->across,
                         v = (y + (double)k / POINTS) / film->down, a = (u - 0.5) * 2 * M_PI,
                         e = (0.5 - v) * M_PI;
            best = fmax(best, cos(e) * sin(a) * gaze[0] + sin(e) * gaze[1] - cos(e) * cos(a) * gaze[2]);
        }
    return best;
}

static void nearest_point(void **state)
{
    (void)state;
    static const int width[] = {128, 384, 512, 2048};
    uint64_t random = 3;
    double worst = 0;
    for (int w = 0; w < 4; w++) {
        struct rnd_render render;
        begin(&render, width[w]);
        const struct rnd_film *film = &render.film;
        for (int k = 0; k < 300; k++) {
            float gaze[3] = {0, k % 2 ? 1 : -1, 0}; /* first the poles, then on the seam, then anywhere */
            if (k >= 2)
                rnd_direction(k < 12 ? (float)M_PI : (float)(2 * M_PI * random_unit(&random)),
                              asinf((float)(2 * random_unit(&random) - 1)), gaze);
            const int x = (int)(random_bits(&random) % (uint32_t)film->across),
                      y = (int)(random_bits(&random) % (uint32_t)film->down);
            const double angle = acos(fmin(1, (double)rnd_tile_cosine(film, x, y, gaze))),
                         points = acos(fmin(1, cosine_by_points(film, x, y, gaze)));
            /* the nearest place may lie between the points, at most half a step away */
            assert_true(angle <= points + 1e-3 &&
                        angle >= points - 0.75 * M_PI / film->down / 48 * 1.5 - 1e-3);
            worst = fmax(worst, fabs(angle - points) * film->down);
        }
        rnd_film_finish(&render.film);
    }
    print_message("apart from the nearest of 49 x 49 points by %.4f of a tile's height at most\n",
                  worst / M_PI);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_news),
        cmocka_unit_test(black_beside_light),
        cmocka_unit_test(bright_hides_nothing),
        cmocka_unit_test(units),
        cmocka_unit_test(many_paths),
        cmocka_unit_test(area_counts),
        cmocka_unit_test(shown),
        cmocka_unit_test(rare_light_shown),
        cmocka_unit_test(nearest_point),
    };
    return cmocka_run_group_tests_name("renderer_judge", tests, files_setup, files_teardown);
}
