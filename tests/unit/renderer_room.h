/* A room and films of it, for the tests of the film and of threads. All tests of a binary share the scene. */
#ifndef FOVEAD_TESTS_RENDERER_ROOM_H
#define FOVEAD_TESTS_RENDERER_ROOM_H

#include "renderer_files.h"

enum { WIDTH = 512, HEIGHT = 256, PIXELS = WIDTH * HEIGHT, TILES = WIDTH / RND_TILE * (HEIGHT / RND_TILE) };

static struct rnd_scene *room;

static inline int setup(void **state)
{
    if (files_setup(state) != 0) return -1;
    room = files_load(files_room("room.obj"), NULL, NULL, NULL);
    return 0;
}

static inline int teardown(void **state)
{
    rnd_scene_destroy(room);
    return files_teardown(state);
}

static inline struct rnd_render *make(const struct rnd_scene *scene, int width, const char *distribution,
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

/* Trace an outline and a few batches around a gaze that moves across a pole and the seam. Returns the number
 * of paths. */
static inline uint64_t look_around(struct rnd_render *render, int batches, uint32_t paths)
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

#endif
