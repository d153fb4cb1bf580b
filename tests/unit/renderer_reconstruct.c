/* Reconstructions of this test's own: what they are given of a film, and what they show of it. */
#include "renderer_room.h"

#include "film/film.h"
#include "reconstruct/reconstruct.h"

/* --- a row is asked for what is shown --- */

static int begun, ended;

static bool begin(int width, int height, void **out_memory)
{
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    begun++;
    *out_memory = malloc(sizeof(int));
    if (*out_memory) *(int *)*out_memory = 360;
    return *out_memory;
}

static void end(void *memory)
{
    ended++;
    free(memory);
}

/* Shows which tile it is, if there is any path. */
static bool run_stamp(void *memory, const struct rnd_window *window, float *out_rgb)
{
    float paths = 0;
    assert_int_equal(*(int *)memory, 360);
    assert_int_equal(window->side, RND_TILE);
    for (int i = 0; i < RND_TILE * RND_TILE; i++) {
        const float rgb[3] = {(float)window->level, (float)window->x, (float)window->y};
        memcpy(&out_rgb[3 * i], rgb, sizeof rgb);
        paths += window->pixel[i].paths;
    }
    return paths > 0;
}

static const struct rnd_reconstruction stamp = {
    .name = "stamp", .begin = begin, .run = run_stamp, .end = end};

static struct rnd_render *make_shown(const struct rnd_reconstruction *row, char out_error[RND_ERROR_SIZE])
{
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .threads = 2,
                                               .seed = 42,
                                               .distribution = rnd_distribution_find("fv"),
                                               .reconstruction = row};
    return rnd_render_create(room, &options, out_error);
}

/* What is shown is the row's; what is resolved is the film's mean all the same. */
static void chosen(void **state)
{
    (void)state;
    static struct film film[2];
    float rgb[RND_TILE * RND_TILE * 3];
    char error[RND_ERROR_SIZE];
    begun = ended = 0;
    for (int i = 0; i < 2; i++) {
        struct rnd_render *render = make_shown(i ? &stamp : NULL, error);
        struct rnd_tile tile;
        assert_non_null(render);
        assert_int_equal(begun, i);
        assert_false(rnd_render_read(render, 0, 0, 0, rgb, &tile));
        assert_int_equal(tile.generation, 1);
        look_around(render, 5, 6000);
        for (int level = 0; level < 3; level++) {
            assert_true(rnd_render_read(render, level, 3 >> level, 2 >> level, rgb, &tile));
            assert_true(tile.samples > 0);
            for (int k = 0; i && k < RND_TILE * RND_TILE; k++)
                assert_true(rgb[3 * k] == (float)level && rgb[3 * k + 1] == (float)(3 >> level) &&
                            rgb[3 * k + 2] == (float)(2 >> level));
        }
        rnd_render_resolve(render, film[i].rgb, film[i].samples, film[i].error);
        assert_int_equal(ended, 0);
        rnd_render_destroy(render);
    }
    assert_int_equal(ended, 1);
    assert_memory_equal(&film[0], &film[1], sizeof film[0]);
}

static bool begin_nothing(int width, int height, void **out_memory)
{
    (void)width, (void)height, (void)out_memory;
    return false;
}

static void no_memory(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE];
    const struct rnd_reconstruction row = {
        .name = "none", .begin = begin_nothing, .run = run_stamp, .end = end};
    ended = 0;
    assert_null(make_shown(&row, error));
    assert_non_null(strstr(error, "memory"));
    assert_int_equal(ended, 0); /* what has not begun does not end */
}

/* --- neighbours --- */

enum { RADIUS = 11 };

/* Radiance from the direction (u, v) of the panorama; beyond a pole the formula goes on on the other side. */
static void from_direction(double u, double v, double out[3])
{
    const double azimuth = 2 * M_PI * (u - 0.5), elevation = M_PI * (0.5 - v);
    out[0] = 2 + cos(elevation) * sin(azimuth);
    out[1] = 2 + sin(elevation);
    out[2] = 2 - cos(elevation) * cos(azimuth);
}

/* Two paths in every pixel, of the radiance from its middle. */
static void fill(struct rnd_film *film)
{
    static struct rnd_sample samples[2 * RND_TILE_PIXELS];
    static const struct rnd_aim aim;
    for (int t = 0; t < film->across * film->down; t++) {
        for (uint32_t i = 0; i < 2 * RND_TILE_PIXELS; i++) {
            const uint32_t pixel = i / 2;
            double rgb[3];
            from_direction((t % film->across * RND_TILE + (int)pixel % RND_TILE + 0.5) / film->width,
                           (t / film->across * RND_TILE + (int)pixel / RND_TILE + 0.5) / film->height, rgb);
            samples[i] = (struct rnd_sample){
                pixel, rnd_film_draw(&film->tile[t], pixel), {(float)rgb[0], (float)rgb[1], (float)rgb[2]}};
        }
        rnd_film_add(film, &film->tile[t], samples, NULL, 2 * RND_TILE_PIXELS, &aim, 1);
    }
}

/* All of a window is what the directions of its pixels say. Shows how far off it is. */
static bool run_neighbours(void *memory, const struct rnd_window *window, float *out_rgb)
{
    const int radius = (window->side - RND_TILE) / 2, across = WIDTH >> window->level,
              down = HEIGHT >> window->level;
    double off = 0;
    (void)memory;
    assert_int_equal(radius, RADIUS);
    for (int y = 0; y < window->side; y++)
        for (int x = 0; x < window->side; x++) {
            const struct rnd_sum *sum = &window->pixel[y * window->side + x];
            double rgb[3];
            assert_true(sum->area == (float)(1 << 2 * window->level));
            from_direction((window->x * RND_TILE + x - radius + 0.5) / across,
                           (window->y * RND_TILE + y - radius + 0.5) / down, rgb);
            for (int c = 0; c < 3; c++) off = fmax(off, fabs((double)(sum->light[c] / sum->area) - rgb[c]));
        }
    out_rgb[0] = (float)off;
    return true;
}

static void neighbours(void **state)
{
    (void)state;
    static float rgb[RND_TILE * RND_TILE * 3];
    const struct rnd_reconstruction row = {.name = "neighbours", .radius = RADIUS, .run = run_neighbours};
    struct rnd_reconstructor reconstructor;
    struct rnd_film film;
    struct rnd_tile tile;
    assert_true(rnd_film_init(&film, WIDTH, HEIGHT, 0.05f, 0));
    fill(&film);
    assert_true(rnd_reconstructor_init(&reconstructor, &row, &film));
    for (int level = 0; level < 3; level++)
        for (int t = 0; t < TILES >> 2 * level; t++) {
            const int across = film.across >> level;
            assert_true(rnd_reconstruct(&reconstructor, level, t % across, t / across, rgb, &tile));
            /* a pixel of a level is the mean of its parts, and curves away from the middle of it */
            assert_true(rgb[0] < (level ? 1e-3 * (1 << 2 * level) : 1e-6));
            assert_int_equal(tile.samples, 2 * RND_TILE_PIXELS << 2 * level);
        }
    /* a neighbour of another generation: the picture begins anew just now */
    rnd_film_empty(&film, &film.tile[1], 2);
    assert_false(rnd_reconstruct(&reconstructor, 0, 0, 0, rgb, &tile));
    assert_int_equal(tile.generation, 1);
    assert_true(rnd_reconstruct(&reconstructor, 0, 4, 1, rgb, &tile));
    rnd_reconstructor_finish(&reconstructor);
    rnd_film_finish(&film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(chosen), cmocka_unit_test(no_memory),
                                       cmocka_unit_test(neighbours)};
    return cmocka_run_group_tests_name("renderer_reconstruct", tests, setup, teardown);
}
