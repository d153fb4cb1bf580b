/* Threads: the film is the same bit for bit with any number of them, and may be read while they work. One
 * scene for all, since Embree takes up a second device in ways that the thread sanitizer cannot follow.
 */
#include "renderer_room.h"

#include <pthread.h>
#include <stdatomic.h>

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
