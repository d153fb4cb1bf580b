/* Reconstructions defined by this test: what they receive of a film, and what they show of it. */
#include "renderer_room.h"

#include "film/film.h"
#include "reconstruct/reconstruct.h"
#include "render.h"

#include <pthread.h>
#include <stdatomic.h>

/* --- the chosen row of the table decides what is shown --- */

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

/* Shows the tile's number if the tile has any path. */
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

static struct rnd_render *make_of(const struct rnd_scene *scene, const struct rnd_reconstruction *row,
                                  char out_error[RND_ERROR_SIZE])
{
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .threads = 2,
                                               .seed = 42,
                                               .distribution = rnd_distribution_find("fv"),
                                               .reconstruction = row};
    return rnd_render_create(scene, &options, out_error);
}

static struct rnd_render *make_shown(const struct rnd_reconstruction *row, char out_error[RND_ERROR_SIZE])
{
    return make_of(room, row, out_error);
}

/* The row decides what is shown. What is resolved is still the film's mean. */
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
    assert_int_equal(ended, 0); /* what has not begun is not ended */
}

/* --- neighbours --- */

enum { RADIUS = 11 };

/* The radiance from the direction (u, v) of the panorama. Beyond a pole the formula continues on the other
 * side. */
static void from_direction(double u, double v, double out[3])
{
    const double azimuth = 2 * M_PI * (u - 0.5), elevation = M_PI * (0.5 - v);
    out[0] = 2 + cos(elevation) * sin(azimuth);
    out[1] = 2 + sin(elevation);
    out[2] = 2 - cos(elevation) * cos(azimuth);
}

/* Add two paths to every pixel, with the radiance from the direction of its middle. */
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

/* Compare every pixel of the window with the radiance from its direction. Shows the largest difference. */
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
    assert_true(rnd_film_init(&film, WIDTH, HEIGHT, 0.05f, 0, &(struct rnd_camera){0}));
    fill(&film);
    assert_true(rnd_reconstructor_init(&reconstructor, &row, &film, NULL));
    for (int level = 0; level < 3; level++)
        for (int t = 0; t < TILES >> 2 * level; t++) {
            const int across = film.across >> level;
            assert_true(rnd_reconstruct(&reconstructor, level, t % across, t / across, rgb, &tile));
            /* a pixel of a level is the mean of its parts, which differs from the radiance at its middle */
            assert_true(rgb[0] < (level ? 1e-3 * (1 << 2 * level) : 1e-6));
            assert_int_equal(tile.samples, 2 * RND_TILE_PIXELS << 2 * level);
        }
    /* A neighbour has another generation: the picture is just starting anew. */
    film.tile[1].state.generation = 2;
    assert_false(rnd_reconstruct(&reconstructor, 0, 0, 0, rgb, &tile));
    assert_int_equal(tile.generation, 1);
    assert_true(rnd_reconstruct(&reconstructor, 0, 4, 1, rgb, &tile));
    rnd_reconstructor_finish(&reconstructor);
    rnd_film_finish(&film);
}

/* --- history --- */

/* What a row finds in a tile's history. */
struct found {
    bool any;
    struct rnd_camera present, former;
    float mean[RND_TILE * RND_TILE][3], paths[RND_TILE * RND_TILE];
    bool astray; /* the history's camera does not see one of the positions in its pixel */
};

static _Thread_local struct found found;

/* Does the camera see the position within pixel (x, y) of the film, or in the next pixel? Always true near
 * the poles, where pixels are too narrow to tell. */
static bool sees(const struct rnd_camera *camera, const float position[3], int x, int y)
{
    double d[3], length = 0;
    for (int c = 0; c < 3; c++) {
        d[c] = (double)(position[c] - camera->position[c]);
        length += d[c] * d[c];
    }
    const double u = (0.5 + atan2(d[0], -d[2]) / (2 * M_PI)) * WIDTH - x - 0.5,
                 v = (0.5 - asin(d[1] / sqrt(length)) / M_PI) * HEIGHT - y - 0.5;
    return y < HEIGHT / 4 || y >= 3 * HEIGHT / 4 || (fabs(u - WIDTH * round(u / WIDTH)) < 1 && fabs(v) < 1);
}

/* In a closed room every path hits something. */
static void check_positions(const struct rnd_window *window, const struct rnd_camera *camera,
                            const struct rnd_sum *sums, const float *values)
{
    for (int i = 0; i < RND_TILE_PIXELS; i++) {
        const float *value = values + 4 * i; /* x, y, z of the position, then coverage */
        if (sums[i].paths == 0) continue;
        if (value[3] != 1 ||
            !sees(camera, value, window->x * RND_TILE + i % RND_TILE, window->y * RND_TILE + i / RND_TILE))
            found.astray = true;
    }
}

static bool run_history(void *memory, const struct rnd_window *window, float *out_rgb)
{
    static _Thread_local struct rnd_sums sums;
    static _Thread_local float planes[RND_TILE_PIXELS * 4];
    (void)memory, (void)out_rgb;
    memset(&found, 0, sizeof found);
    found.present = window->camera;
    check_positions(window, &window->camera, window->pixel, window->values);
    found.any = rnd_window_history(window, window->level, window->x, window->y, &sums, planes);
    if (!found.any) return true;
    found.former = sums.camera;
    check_positions(window, &sums.camera, sums.pixel, planes);
    for (int i = 0; i < RND_TILE_PIXELS; i++) {
        const struct rnd_sum *sum = &sums.pixel[i];
        found.paths[i] = sum->paths;
        for (int c = 0; c < 3 && sum->area > 0; c++) found.mean[i][c] = sum->light[c] / sum->area;
    }
    return true;
}

static const struct rnd_reconstruction keeper = {.name = "keeper",
                                                 .planes = RND_PLANE(POSITION) | RND_PLANE(COVERAGE),
                                                 .keeps_history = true,
                                                 .run = run_history};

/* Check that no tile has a history (camera is NULL), or that the history of every tile is that film, seen
 * from that camera. */
static void check_history(struct rnd_render *render, const struct film *film, const double *camera,
                          bool is_closed)
{
    static float rgb[RND_TILE * RND_TILE * 3];
    int tiles = 0;
    for (int t = 0; t < TILES; t++) {
        const int left = t % (WIDTH / RND_TILE) * RND_TILE, top = t / (WIDTH / RND_TILE) * RND_TILE;
        assert_true(rnd_render_read(render, 0, left / RND_TILE, top / RND_TILE, rgb, NULL));
        if (is_closed) assert_false(found.astray);
        if (!camera) assert_false(found.any);
        if (!found.any) continue; /* no history, or no path fell into this tile */
        tiles++;
        for (int c = 0; c < 3; c++) assert_float_equal(found.former.position[c], camera[c], 1e-6);
        for (int i = 0; i < RND_TILE_PIXELS; i++) {
            const int at = (top + i / RND_TILE) * WIDTH + left + i % RND_TILE;
            assert_true(found.paths[i] == film->samples[at]);
            assert_memory_equal(found.mean[i], &film->rgb[3 * at], sizeof found.mean[i]);
        }
    }
    if (camera) assert_int_equal(tiles, TILES);
}

static const double places[4][3] = {{0, 0, 0}, {0.7, 0.2, 1}, {-0.6, -0.3, 0.8}, {1.1, 0.4, 0.5}};

static void former_camera(void **state)
{
    (void)state;
    static struct film film[2], plain;
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = make_shown(&keeper, error), *other = make_shown(NULL, error);
    assert_true(room->origin[0] == 0 && room->origin[1] == 0 && room->origin[2] == 0);
    rnd_render_restart(render, room, places[0]);
    look_around(render, 5, 6000);
    check_history(render, NULL, NULL, true);
    rnd_render_resolve(render, film[0].rgb, film[0].samples, film[0].error);

    rnd_render_restart(render, room, places[1]);
    check_history(render, &film[0], places[0], true); /* before there is a path */
    look_around(render, 4, 6000);
    check_history(render, &film[0], places[0], true); /* while there are fewer paths than in film[0] */
    rnd_render_restart(render, room, places[2]);
    check_history(render, &film[0], places[0], true); /* film[0] has more paths than the film in between */
    look_around(render, 3, 8000);
    check_history(render, &film[0], places[0], true);
    look_around(render, 1, 6000);
    check_history(render, NULL, NULL, true); /* now there are as many paths */
    rnd_render_resolve(render, film[1].rgb, film[1].samples, film[1].error);
    rnd_render_restart(render, room, places[3]);
    check_history(render, &film[1], places[2], true);
    look_around(render, 4, 6000);

    /* The picture is the same as without history. */
    rnd_render_resolve(render, film[0].rgb, film[0].samples, film[0].error);
    rnd_render_restart(other, room, places[3]);
    look_around(other, 4, 6000);
    rnd_render_resolve(other, plain.rgb, plain.samples, plain.error);
    assert_memory_equal(&film[0], &plain, sizeof plain);
    rnd_render_destroy(render);
    rnd_render_destroy(other);
}

/* After a change of scene or of textures, the former picture is not used as history. */
static void edited(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE];
    const float colour[3] = {0.25f, 0.5f, 0.75f};
    assert_true(files_image(files_path("colour.exr"), 1, 1, colour, false, error));
    const char *material =
                   "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}}}",
               *more = ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"colour.exr\"}]", *warnings;
    const struct rnd_scene_options options = {
        .path = files_gltf("square.gltf", 3, "{\"mesh\":0,\"translation\":[0,-1,0]}", material, more),
        .env_path = files_env("white.exr", 1),
        .image_program = files_image_program(),
        .textures_later = true,
        .has_camera = true};
    static struct film film;
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    struct rnd_render *render = make_of(scene, &keeper, error);
    assert_non_null(render);
    look_around(render, 4, 6000);
    rnd_render_resolve(render, film.rgb, film.samples, film.error);
    rnd_render_restart(render, scene, places[1]);
    const double from[3] = {-scene->origin[0], -scene->origin[1], -scene->origin[2]};
    check_history(render, &film, from, false);
    while (rnd_scene_take_textures(scene, &warnings) != RND_TEXTURES_CAME) usleep(1000);
    rnd_render_restart(render, scene, places[1]);
    check_history(render, NULL, NULL, false);

    look_around(render, 4, 6000);
    rnd_render_restart(render, scene, places[2]);
    look_around(render, 1, 6000);
    rnd_render_restart(render, room, places[2]); /* another scene */
    rnd_scene_destroy(scene);
    check_history(render, NULL, NULL, true);
    look_around(render, 2, 6000);
    check_history(render, NULL, NULL, true);
    rnd_render_destroy(render);
}

/* At most one former film is kept, and none for a row that does not want it. */
static void history_memory(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = make_shown(&keeper, error), *other = make_shown(&stamp, error);
    const void *films[2] = {render->film.pixels, render->history.pixels},
               *planes[2] = {render->film.plane_memory, render->history.plane_memory};
    for (int i = 0; i < 12; i++) {
        look_around(render, i % 5, 3000);
        look_around(other, 1, 3000);
        rnd_render_restart(render, room, places[i % 4]);
        rnd_render_restart(other, room, places[i % 4]);
        const bool turned = render->film.pixels != films[0];
        assert_ptr_equal(render->film.pixels, films[turned]);
        assert_ptr_equal(render->history.pixels, films[!turned]);
        assert_ptr_equal(render->film.plane_memory, planes[turned]);
        for (int t = 0; t < TILES; t++) {
            assert_ptr_equal(render->film.tile[t].pixels, &render->film.pixels[t]);
            assert_ptr_equal(render->history.tile[t].pixels, &render->history.pixels[t]);
        }
        assert_null(other->history.tile);
        assert_null(other->history.pixels);
    }
    assert_true(render->history.paths > 0);
    rnd_render_destroy(render);
    rnd_render_destroy(other);
}

/* A tile without paths that reuses the memory of a tile with paths is empty. */
static void reused_memory(void **state)
{
    (void)state;
    static const struct rnd_camera camera;
    static const struct rnd_sample sample = {.pixel = 9, .rgb = {1, 2, 3}};
    static const struct rnd_aim aim;
    const float albedo[3] = {0.5f, 0.25f, 1};
    struct rnd_film film, history;
    struct rnd_pool *pool = rnd_pool_create(2);
    assert_true(rnd_film_init(&film, WIDTH, HEIGHT, 0.05f, RND_PLANE(ALBEDO), &camera));
    assert_true(rnd_film_init(&history, WIDTH, HEIGHT, 0.05f, RND_PLANE(ALBEDO), &camera));
    for (uint32_t i = 0; i < 3; i++) { /* tile 0, tile 1, and tile 0 again, in the memory of the first time */
        struct rnd_film_tile *tile = &film.tile[i % 2];
        rnd_film_add(&film, tile, &sample, albedo, 1, &aim, 1);
        const float *block = rnd_film_plane_block(&film, tile, 1);
        for (int c = 0; c < 3; c++) assert_true(block[c] == albedo[c]);
        rnd_film_restart(&film, &history, &camera, 2 + i, pool);
        assert_int_equal(history.tile[i % 2].state.samples, 1);
        assert_int_equal(history.tile[(i + 1) % 2].state.samples, 0);
    }
    rnd_film_finish(&film);
    rnd_film_finish(&history);
    rnd_pool_destroy(pool);
}

struct reader {
    struct rnd_render *render;
    atomic_bool quit;
    _Atomic uint64_t astray, newer, histories;
};

/* Read tiles. Cameras move up the x axis, so an earlier camera has a smaller x. */
static void *read_on(void *argument)
{
    struct reader *reader = argument;
    static float rgb[RND_TILE * RND_TILE * 3];
    while (!atomic_load(&reader->quit))
        for (int t = 0; t < TILES; t++) {
            const int across = WIDTH / RND_TILE;
            if (!rnd_render_read(reader->render, 0, t % across, t / across, rgb, NULL)) continue;
            reader->astray += found.astray;
            reader->histories += found.any;
            reader->newer += found.any && !(found.former.position[0] < found.present.position[0]);
        }
    return NULL;
}

/* A thread that reads while the camera moves gets pixels, planes and camera of the same picture, and a
 * history that is earlier. */
static void readers(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = make_shown(&keeper, error);
    struct reader reader = {.render = render};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, read_on, &reader), 0);
    for (int i = 0; i < 60 || (i < 100000 && reader.histories < 1000); i++) {
        rnd_render_restart(render, room, (const double[]){0.3 + 1e-3 * i, 0, 0.3});
        look_around(render, i % 3, 2000);
    }
    atomic_store(&reader.quit, true);
    pthread_join(thread, NULL);
    print_message("histories read: %llu\n", (unsigned long long)reader.histories);
    assert_true(reader.histories >= 1000);
    assert_int_equal(reader.astray, 0);
    assert_int_equal(reader.newer, 0);
    rnd_render_destroy(render);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(chosen),        cmocka_unit_test(no_memory),
                                       cmocka_unit_test(neighbours),    cmocka_unit_test(former_camera),
                                       cmocka_unit_test(edited),        cmocka_unit_test(history_memory),
                                       cmocka_unit_test(reused_memory), cmocka_unit_test(readers)};
    return cmocka_run_group_tests_name("renderer_reconstruct", tests, setup, teardown);
}
