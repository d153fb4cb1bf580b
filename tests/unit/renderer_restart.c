/* Restarts: a restarted render is the same as a new one, bit for bit, and threads that read meanwhile see one
 * generation at a time. */
#include "renderer_room.h"

#include <pthread.h>
#include <stdatomic.h>

/* Everything that can be read of a render. */
struct all {
    struct film film;
    struct rnd_tile tiles[TILES], state[TILES];
    float coarse[TILES][RND_TILE * RND_TILE * 3];
};

static void read_all(struct rnd_render *render, struct all *all)
{
    int n = 0;
    memset(all, 0, sizeof *all);
    rnd_render_resolve(render, all->film.rgb, all->film.samples, all->film.error);
    rnd_render_tiles(render, all->tiles);
    for (int level = 1; level < rnd_render_levels(render); level++)
        for (int t = 0; t < TILES >> 2 * level; t++, n++) {
            const int across = WIDTH / RND_TILE >> level;
            rnd_render_read(render, level, t % across, t / across, all->coarse[n], &all->state[n]);
        }
    for (int t = 0; t < TILES; t++) all->tiles[t].generation = all->state[t].generation = 0;
}

static void assert_same(const struct all *one, const struct all *other)
{
    assert_memory_equal(&one->film, &other->film, sizeof one->film);
    for (int t = 0; t < TILES; t++) {
        const struct rnd_tile *pairs[2][2] = {{&one->tiles[t], &other->tiles[t]},
                                              {&one->state[t], &other->state[t]}};
        for (int i = 0; i < 2; i++) {
            const struct rnd_tile *a = pairs[i][0], *b = pairs[i][1];
            assert_int_equal(a->samples, b->samples);
            assert_int_equal(a->unvisited, b->unvisited);
            assert_true(a->error == b->error && a->sure_error == b->sure_error &&
                        a->luminance == b->luminance);
            assert_int_equal(a->converged, b->converged);
            assert_int_equal(a->gaze_sequence, b->gaze_sequence);
            assert_int_equal(a->gaze_ns, b->gaze_ns);
            assert_int_equal(a->aimed_ns, b->aimed_ns);
        }
    }
    assert_memory_equal(one->coarse, other->coarse, sizeof one->coarse);
}

/* Read everything of a new render of the scene. */
static void fresh(const struct rnd_scene *scene, struct all *all)
{
    struct rnd_render *render = make(scene, WIDTH, "fv", 2);
    look_around(render, 5, 6000);
    read_all(render, all);
    rnd_render_destroy(render);
}

static void as_fresh(void **state)
{
    (void)state;
    static struct all first, other, again, before;
    static const double near_the_wall[3] = {1.2, -0.4, 1.1};
    struct rnd_scene *scene =
        files_load(files_path("room.obj"), files_env("dim.exr", 0.25f), NULL, (float[]){1.2f, -0.4f, 1.1f});
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    fresh(room, &first);
    fresh(scene, &other);
    assert_memory_not_equal(&first.film, &other.film, sizeof first.film);

    look_around(render, 9, 2000); /* earlier paths must not matter */
    rnd_render_restart(render, room, rnd_scene_info(room)->camera);
    look_around(render, 5, 6000);
    read_all(render, &again);
    assert_same(&first, &again);

    rnd_render_restart(render, scene, near_the_wall); /* another scene from another place */
    look_around(render, 5, 6000);
    read_all(render, &again);
    assert_same(&other, &again);

    rnd_render_restart(render, room, near_the_wall); /* the first scene from another place */
    rnd_scene_destroy(scene);                        /* no render uses it any more */
    look_around(render, 5, 6000);
    read_all(render, &before);
    assert_memory_not_equal(&before.film, &first.film, sizeof first.film);
    look_around(render, 3, 1000);
    rnd_render_restart(render, room, near_the_wall);
    look_around(render, 5, 6000);
    read_all(render, &again);
    assert_same(&before, &again);
    rnd_render_destroy(render);
}

/* A batch whose aim is stale from the start traces no path: no tile answers its gaze, and a restart after it
 * is still the same as a new render. */
static void left_out(void **state)
{
    (void)state;
    static struct all first, again;
    struct rnd_tile tiles[TILES];
    struct rnd_batch batch;
    const atomic_bool stale = true;
    struct rnd_aim aim = files_aim(0, 0, -1);
    aim.sequence = 7;
    aim.time_ns = 70;
    aim.stale = &stale;
    fresh(room, &first);
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    rnd_render_batch(render, &aim, 1, 8000, &batch);
    assert_int_equal(batch.paths, 0);
    rnd_render_tiles(render, tiles);
    for (int t = 0; t < TILES; t++) {
        assert_int_equal(tiles[t].samples, 0);
        assert_true(tiles[t].gaze_sequence == 0 && tiles[t].gaze_ns == 0 && tiles[t].aimed_ns == 0);
    }
    rnd_render_restart(render, room, rnd_scene_info(room)->camera);
    look_around(render, 5, 6000);
    read_all(render, &again);
    assert_same(&first, &again);

    rnd_render_batch(render, &aim, 9999, 8000, &batch);
    rnd_render_tiles(render, tiles);
    for (int t = 0; t < TILES; t++) assert_int_equal(tiles[t].gaze_sequence, again.tiles[t].gaze_sequence);
    rnd_render_destroy(render);
}

/* Nothing of the old picture is left, and tiles have the new generation. */
static void empty(void **state)
{
    (void)state;
    static struct all all;
    struct rnd_tile tiles[TILES], tile;
    float rgb[RND_TILE * RND_TILE * 3];
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    for (uint32_t generation = 1; generation <= 3; generation++) {
        rnd_render_tiles(render, tiles);
        read_all(render, &all);
        for (int t = 0; t < TILES; t++) {
            assert_int_equal(tiles[t].generation, generation);
            assert_int_equal(tiles[t].samples, 0);
            assert_int_equal(tiles[t].unvisited, RND_TILE * RND_TILE);
            assert_true(isinf(tiles[t].error) && !tiles[t].converged && tiles[t].aimed_ns == 0);
        }
        for (int i = 0; i < PIXELS; i++)
            assert_true(all.film.rgb[3 * i] == 0 && all.film.samples[i] == 0 && all.film.error[i] == 0);
        for (int level = 0; level < 3; level++) {
            assert_false(rnd_render_read(render, level, 0, 0, rgb, &tile));
            assert_int_equal(tile.generation, generation);
        }
        look_around(render, 4, 8000);
        assert_true(rnd_render_read(render, 2, 0, 0, rgb, &tile));
        assert_int_equal(tile.generation, generation);
        rnd_render_restart(render, room, rnd_scene_info(room)->camera);
    }
    rnd_render_destroy(render);
}

/* --- threads read while a white and a grey world take turns --- */

struct reader {
    struct rnd_render *render;
    atomic_bool quit;
    _Atomic uint64_t whole[2], tiles[2], wrong; /* how often each world was seen, in pictures and in tiles */
};

/* Odd generations are white, even ones grey. */
static float shade_of(uint32_t generation)
{
    return generation % 2 ? 1.0f : 0.125f;
}

static void read_picture(struct reader *reader)
{
    static float rgb[3 * PIXELS], samples[PIXELS];
    float seen = 0;
    rnd_render_resolve(reader->render, rgb, samples, NULL);
    for (int i = 0; i < PIXELS; i++) {
        if (samples[i] == 0) continue;
        if (seen == 0) seen = rgb[3 * i] > 0.5f ? 1.0f : 0.125f;
        reader->wrong += fabsf(rgb[3 * i] - seen) > 1e-5f;
    }
    if (seen > 0) reader->whole[seen < 0.5f]++;
}

static void *read_on(void *argument)
{
    struct reader *reader = argument;
    float rgb[RND_TILE * RND_TILE * 3];
    while (!atomic_load(&reader->quit)) {
        for (int level = 0; level < 3; level++) {
            struct rnd_tile tile;
            if (!rnd_render_read(reader->render, level, 1 >> level, 0, rgb, &tile)) continue;
            reader->tiles[(tile.generation + 1) % 2]++;
            for (int i = 0; i < RND_TILE * RND_TILE; i++)
                reader->wrong += fabsf(rgb[3 * i] - shade_of(tile.generation)) > 1e-5f;
        }
        read_picture(reader);
    }
    return NULL;
}

/* On a busy machine a reading thread may sleep through many restarts. */
static bool saw_both(struct reader *reader)
{
    return reader->tiles[0] > 0 && reader->tiles[1] > 0 && reader->whole[0] + reader->whole[1] > 0;
}

static void readers(void **state)
{
    (void)state;
    /* The world is only an environment, and a speck that no camera sees. */
    files_text("speck.mtl", "newmtl m\nKd 0 0 0\n");
    const char *path =
        files_text("speck.obj", "mtllib speck.mtl\nusemtl m\nv 0 -9 0\nv 1e-4 -9 0\nv 0 -9 1e-4\nf 1 2 3\n");
    static const double camera[3] = {0, 0, 0};
    struct rnd_scene *world[2];
    for (int i = 0; i < 2; i++)
        world[i] = files_load(path, files_env(i ? "grey.exr" : "white.exr", shade_of((uint32_t)i + 1)), NULL,
                              (float[]){0, 0, 0});
    struct rnd_render *render = make(world[0], WIDTH, "od", 2);
    struct reader reader = {.render = render};
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, read_on, &reader), 0);
    for (uint32_t i = 1; i <= 60 || (i <= 100000 && !saw_both(&reader)); i++) {
        rnd_render_outline(render, &aim, i, &batch);
        for (int k = 0; k < 3; k++) rnd_render_batch(render, &aim, i, 1000, &batch);
        rnd_render_restart(render, world[i % 2], camera);
    }
    atomic_store(&reader.quit, true);
    pthread_join(thread, NULL);
    print_message("seen: pictures %llu white, %llu grey; tiles %llu white, %llu grey\n",
                  (unsigned long long)reader.whole[0], (unsigned long long)reader.whole[1],
                  (unsigned long long)reader.tiles[0], (unsigned long long)reader.tiles[1]);
    assert_true(saw_both(&reader));
    assert_int_equal(reader.wrong, 0);
    rnd_render_destroy(render);
    for (int i = 0; i < 2; i++) rnd_scene_destroy(world[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(as_fresh), cmocka_unit_test(left_out),
                                       cmocka_unit_test(empty), cmocka_unit_test(readers)};
    return cmocka_run_group_tests_name("renderer_restart", tests, setup, teardown);
}
