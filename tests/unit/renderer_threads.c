/* Threads: the film is the same, bit for bit, with any number of them, and may be read while they work. All
 * tests share one scene, because Embree uses a second device in ways that ThreadSanitizer cannot follow. */
#include "renderer_room.h"

#include "render.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

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
    uint64_t reads, whole, wrong, changes;
    struct rnd_tile known[TILES]; /* from rnd_render_published() */
};

static void *read_on(void *argument)
{
    struct reader *reader = argument;
    static float rgb[3 * PIXELS], samples[PIXELS], tile_rgb[RND_TILE * RND_TILE * 3];
    struct rnd_tile tiles[TILES];
    uint32_t changed[TILES];
    bool last;
    do { /* one more time after the last batch */
        last = atomic_load(&reader->quit);
        rnd_render_tiles(reader->render, tiles);
        reader->changes += rnd_render_published(reader->render, reader->known, changed);
        for (int level = 0; level < 3; level++) {
            struct rnd_tile tile;
            /* also false while another thread adds to the tile */
            if (!rnd_render_read(reader->render, level, 0, 0, tile_rgb, &tile)) continue;
            reader->wrong += tile.samples == 0;
            reader->whole++;
        }
        rnd_render_resolve(reader->render, rgb, samples, NULL);
        reader->reads++;
    } while (!last);
    return NULL;
}

/* Check that the published states of tiles are the current ones. */
static void assert_known(struct rnd_render *render, const struct rnd_tile *known)
{
    struct rnd_tile tiles[TILES];
    rnd_render_tiles(render, tiles);
    for (int t = 0; t < TILES; t++) {
        assert_int_equal(tiles[t].samples, known[t].samples);
        assert_int_equal(tiles[t].unvisited, known[t].unvisited);
        assert_int_equal(tiles[t].generation, known[t].generation);
        assert_int_equal(tiles[t].gaze_sequence, known[t].gaze_sequence);
        assert_true(tiles[t].error == known[t].error && tiles[t].converged == known[t].converged);
    }
}

/* A film may be read while a batch runs: ThreadSanitizer checks the reads, and the film comes out the same.
 */
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
            assert_true(reader.reads > 0 && reader.whole > 0 && reader.changes >= TILES);
            assert_int_equal(reader.wrong, 0);
            assert_known(render, reader.known);
        }
        struct film *film = i == 0 ? &alone : &watched;
        rnd_render_resolve(render, film->rgb, film->samples, film->error);
        rnd_render_destroy(render);
    }
    assert_memory_equal(&alone, &watched, sizeof alone);
}

/* Only tiles that have changed are reported, with their new state. */
static void published(void **state)
{
    (void)state;
    struct rnd_render *render = make(room, WIDTH, "vp", 2);
    struct rnd_tile known[TILES], before[TILES];
    uint32_t changed[TILES];
    struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    aim.fov[0] = aim.fov[1] = 0.4f;
    assert_int_equal(rnd_render_published(render, known, changed), TILES); /* at first all */
    assert_known(render, known);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(rnd_render_published(render, known, changed), 0);
        memcpy(before, known, sizeof before);
        rnd_render_batch(render, &aim, 7, 1000, &batch);
        const uint32_t count = rnd_render_published(render, known, changed);
        assert_known(render, known);
        assert_true(count > 0 && count < TILES);
        uint64_t paths = 0;
        for (uint32_t k = 0; k < count; k++) {
            assert_true(k == 0 || changed[k] > changed[k - 1]);
            assert_true(known[changed[k]].samples > before[changed[k]].samples);
            paths += known[changed[k]].samples - before[changed[k]].samples;
        }
        assert_int_equal(paths, 1000);
    }
    rnd_render_restart(render, room, rnd_scene_info(room)->camera);
    assert_int_equal(rnd_render_published(render, known, changed), TILES);
    assert_known(render, known);
    assert_int_equal(known[0].generation, 2);
    rnd_render_destroy(render);
}

/* When the system suspends a thread that is adding to a tile, threads that read do not wait for it. */
static void writer_put_aside(void **state)
{
    (void)state;
    static float rgb[RND_TILE * RND_TILE * 3];
    struct rnd_render *render = make(room, WIDTH, "fv", 1);
    struct rnd_tile tiles[TILES], tile;
    look_around(render, 3, 4000);
    pthread_mutex_lock(&render->film.tile[1].lock);
    rnd_render_tiles(render, tiles);
    assert_true(tiles[1].samples > 0);
    assert_true(rnd_render_read(render, 0, 2, 0, rgb, &tile));
    for (int level = 0; level < 3; level++) {
        assert_false(rnd_render_read(render, level, 1 >> level, 0, rgb, &tile));
        assert_true(tile.samples >= tiles[1].samples);
    }
    pthread_mutex_unlock(&render->film.tile[1].lock);
    for (int level = 0; level < 3; level++)
        assert_true(rnd_render_read(render, level, 1 >> level, 0, rgb, &tile));
    rnd_render_destroy(render);
}

/* --- the pool --- */

enum { POOL = 4, TURNS = 100 };

struct turns {
    _Atomic int next, done[TURNS], calls[POOL];
};

static void take_turns(void *context, int worker)
{
    struct turns *turns = context;
    atomic_fetch_add(&turns->calls[worker], 1);
    for (int i; (i = atomic_fetch_add(&turns->next, 1)) < TURNS;) atomic_fetch_add(&turns->done[i], 1);
}

/* Every item is taken once, by any thread. No thread is called twice, and rnd_pool_run_all() calls every
 * thread. */
static void pool_turns(void **state)
{
    (void)state;
    struct rnd_pool *pool = rnd_pool_create(POOL);
    assert_non_null(pool);
    for (int round = 0; round < 2000; round++) {
        struct turns turns = {0};
        const bool all = round % 3 == 0;
        (all ? rnd_pool_run_all : rnd_pool_run)(pool, take_turns, &turns);
        for (int i = 0; i < TURNS; i++) assert_int_equal(turns.done[i], 1);
        assert_int_equal(turns.calls[0], 1);
        for (int i = 1; i < POOL; i++) assert_true(turns.calls[i] == 1 || (turns.calls[i] == 0 && !all));
    }
    rnd_pool_destroy(pool);
}

/* Resident memory of this process, bytes. */
static double resident(void)
{
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*d %ld", &pages), 1);
    fclose(file);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

/* The first coarse picture and a restart after it touch only a small part of the film's memory. */
static void outline_memory(void **state)
{
    (void)state;
    enum { W = 4096, H = W / 2 };
    struct rnd_render *render = make(room, W, "fv", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    const double before = resident(), film = (double)W * H * sizeof(struct rnd_film_pixels) / RND_TILE_PIXELS;
    for (int i = 0; i < 2; i++) {
        rnd_render_outline(render, &aim, 0, &batch);
        rnd_render_restart(render, room, rnd_scene_info(room)->camera);
    }
    print_message("%.1f MB of a film of %.1f MB\n", 1e-6 * (resident() - before), 1e-6 * film);
    assert_true(resident() - before < 0.25 * film); /* includes what sanitizers add */
    rnd_render_destroy(render);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_with_any_threads),
                                       cmocka_unit_test(readers),
                                       cmocka_unit_test(published),
                                       cmocka_unit_test(writer_put_aside),
                                       cmocka_unit_test(outline_memory),
                                       cmocka_unit_test(pool_turns)};
    return cmocka_run_group_tests_name("renderer_threads", tests, setup, teardown);
}
