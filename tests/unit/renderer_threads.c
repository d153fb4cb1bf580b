/* Threads: the film is the same bit for bit with any number of them, and may be read while they work. One
 * scene for all, since Embree takes up a second device in ways that the thread sanitizer cannot follow.
 */
#include "renderer_files.h"

#include <pthread.h>
#include <stdatomic.h>

enum { WIDTH = 512, HEIGHT = 256, PIXELS = WIDTH * HEIGHT, TILES = WIDTH / RND_TILE * (HEIGHT / RND_TILE) };

static struct rnd_scene *room;

static int setup(void **state)
{
    if (files_setup(state) != 0) return -1;
    room = files_load(files_room("room.obj"), NULL, NULL, NULL);
    return 0;
}

static int teardown(void **state)
{
    rnd_scene_destroy(room);
    return files_teardown(state);
}

static struct rnd_render *make(const struct rnd_scene *scene, int width, const char *distribution,
                               int threads)
{
    const struct rnd_render_options options = {.width = width,
                                               .height = width / 2,
                                               .threads = threads,
                                               .seed = 42,
                                               .distribution = rnd_distribution_find(distribution)};
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    return render;
}

/* An outline and a few batches around a gaze that moves over pole and seam. Paths are returned. */
static uint64_t look_around(struct rnd_render *render, int batches, uint32_t paths)
{
    struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    rnd_render_outline(render, &aim, 1, &batch);
    uint64_t sum = batch.paths;
    for (int i = 0; i < batches; i++) {
        aim = files_aim(sin(0.9 * i), 1.2 * sin(0.4 * i), -cos(0.9 * i));
        aim.sequence = 100 + (uint64_t)i;
        aim.time_ns = 1000 + (uint64_t)i;
        rnd_render_batch(render, &aim, 2000 + (uint64_t)i, paths, &batch);
        assert_int_equal(batch.paths, paths);
        assert_int_equal(batch.not_finite, 0);
        assert_true(batch.rays >= batch.paths && batch.seconds >= batch.place_seconds);
        sum += batch.paths;
    }
    return sum;
}

struct film {
    float rgb[3 * PIXELS], samples[PIXELS], error[PIXELS];
};

static void same_with_any_threads(void **state)
{
    (void)state;
    static struct film one, many;
    for (int threads = 1; threads <= 4; threads *= 2) {
        struct rnd_render *render = make(room, WIDTH, "fv", threads);
        struct film *film = threads == 1 ? &one : &many;
        look_around(render, 8, 3000 + 77);
        rnd_render_resolve(render, film->rgb, film->samples, film->error);
        rnd_render_destroy(render);
        if (threads > 1) assert_memory_equal(&one, &many, sizeof one);
    }
}

struct reader {
    struct rnd_render *render;
    atomic_bool quit;
    uint64_t reads, wrong;
};

static void *read_on(void *argument)
{
    struct reader *reader = argument;
    static float rgb[3 * PIXELS], samples[PIXELS], tile_rgb[RND_TILE * RND_TILE * 3];
    struct rnd_tile tiles[TILES];
    while (!atomic_load(&reader->quit)) {
        rnd_render_tiles(reader->render, tiles);
        for (int level = 0; level < 3; level++) {
            struct rnd_tile tile;
            if (rnd_render_read(reader->render, level, 0, 0, tile_rgb, &tile) != (tile.samples > 0))
                reader->wrong++;
        }
        rnd_render_resolve(reader->render, rgb, samples, NULL);
        reader->reads++;
    }
    return NULL;
}

/* A film may be read while a batch runs; what the readers see is for ThreadSanitizer to judge, and the film
 * is the same in the end. */
static void readers(void **state)
{
    (void)state;
    static struct film alone, watched;
    for (int i = 0; i < 2; i++) {
        struct rnd_render *render = make(room, WIDTH, "fv", 2);
        struct reader reader = {.render = render};
        pthread_t thread;
        if (i == 1) assert_int_equal(pthread_create(&thread, NULL, read_on, &reader), 0);
        look_around(render, 10, 4000);
        if (i == 1) {
            atomic_store(&reader.quit, true);
            pthread_join(thread, NULL);
            assert_true(reader.reads > 0);
            assert_int_equal(reader.wrong, 0);
        }
        struct film *film = i == 0 ? &alone : &watched;
        rnd_render_resolve(render, film->rgb, film->samples, film->error);
        rnd_render_destroy(render);
    }
    assert_memory_equal(&alone, &watched, sizeof alone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_with_any_threads), cmocka_unit_test(readers)};
    return cmocka_run_group_tests_name("renderer_threads", tests, setup, teardown);
}
