/* Which tiles a client is sent next. Nothing is rendered: what is known of tiles in, places out. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "next.h"
#include "renderer.h"

enum { WIDTH = 4096, HEIGHT = 2048, LEVELS = 6, LIMIT = 4096, ENOUGH = 4 * RND_TILE * RND_TILE };

static const float FORWARD[3] = {0, 0, -1};

struct world {
    struct dmn_pyramid pyramid;
    struct rnd_tile *tiles;
    bool *settled;
    struct dmn_tile *sent;
    int finest; /* level that the client can hold */
    struct dmn_place places[LIMIT];
    size_t count;
};

static struct world *make(int width, int height, int levels)
{
    struct world *world = calloc(1, sizeof(*world));

    assert_non_null(world);
    assert_true(dmn_pyramid_init(&world->pyramid, width, height, levels));
    world->tiles = calloc(world->pyramid.count, sizeof(*world->tiles));
    world->settled = calloc(world->pyramid.count, sizeof(*world->settled));
    world->sent = calloc(world->pyramid.count, sizeof(*world->sent));
    return world;
}

static int setup(void **state)
{
    *state = make(WIDTH, HEIGHT, LEVELS);
    return 0;
}

static int teardown(void **state)
{
    struct world *world = *state;

    dmn_pyramid_finish(&world->pyramid);
    free(world->tiles);
    free(world->settled);
    free(world->sent);
    free(world);
    return 0;
}

static void paint(struct world *world, uint64_t samples)
{
    size_t count = (size_t)world->pyramid.level[0].columns * world->pyramid.level[0].rows;

    for (size_t i = 0; i < count; i++) {
        world->tiles[i].samples = samples;
        world->tiles[i].error = INFINITY; /* not known */
    }
}

static void update(struct world *world)
{
    size_t count = (size_t)world->pyramid.level[0].columns * world->pyramid.level[0].rows;

    for (size_t i = 0; i < count; i++) {
        const struct rnd_tile *tile = &world->tiles[i];

        dmn_pyramid_set(&world->pyramid, i,
                        &(struct dmn_tile){tile->samples, tile->converged, world->settled[i], tile->error});
    }
    dmn_pyramid_update(&world->pyramid);
}

static void choose(struct world *world, const float gaze[3], size_t limit)
{
    update(world);
    world->count = dmn_next(&world->pyramid, world->sent, gaze, world->finest, limit, world->places);
    assert_true(world->count <= limit);
}

/* With gaze ahead, so many tiles are chosen. */
static void chooses(struct world *world, uint32_t count)
{
    choose(world, FORWARD, LIMIT);
    assert_int_equal(world->count, count);
}

static void send_all(struct world *world)
{
    for (size_t i = 0; i < world->count; i++)
        world->sent[world->places[i].index] = world->pyramid.tile[world->places[i].index];
}

/* Until there is no more to send; returns how many tiles that took. */
static size_t send_until_done(struct world *world, const float gaze[3])
{
    size_t sent = 0;

    for (choose(world, gaze, 64); world->count > 0; choose(world, gaze, 64)) {
        send_all(world);
        sent += world->count;
        assert_true(sent < 20000);
    }
    return sent;
}

/* Is every level-0 tile covered by a tile that was sent, at this level or a finer one? */
static bool covered(const struct world *world, int coarsest)
{
    for (int y = 0; y < world->pyramid.level[0].rows; y++)
        for (int x = 0; x < world->pyramid.level[0].columns; x++) {
            bool any = false;

            for (int l = 0; l <= coarsest; l++) {
                const struct dmn_level *level = &world->pyramid.level[l];

                any |= world->sent[level->first + (size_t)(y >> l) * level->columns + (x >> l)].samples > 0;
            }
            if (!any) return false;
        }
    return true;
}

static void nothing_painted_nothing_sent(void **state)
{
    struct world *world = *state;

    chooses(world, 0);
}

static void an_outline_is_sent_coarsest_first_and_whole(void **state)
{
    struct world *world = *state;

    paint(world, DMN_OUTLINE_PATHS);
    choose(world, FORWARD, LIMIT);
    /* The two tiles of the last level, then the eight of the one before, which have a path per pixel. */
    assert_int_equal(world->count, 10);
    for (size_t i = 0; i < world->count; i++) assert_int_equal(world->places[i].level, i < 2 ? 5 : 4);
    choose(world, FORWARD, 2);
    send_all(world);
    assert_true(covered(world, LEVELS - 1));
}

static void a_fine_picture_ends_fine_everywhere(void **state)
{
    struct world *world = *state;
    size_t fine = (size_t)world->pyramid.level[0].columns * world->pyramid.level[0].rows;

    paint(world, 2 * ENOUGH);
    /* Coarse levels once, then all of level 0, and nothing in between that it would hide at once. */
    assert_int_equal(send_until_done(world, FORWARD), 2 + 8 + 32 + fine);
    assert_true(covered(world, 0));
}

static void finer_tiles_follow_the_gaze(void **state)
{
    struct world *world = *state;
    const float gaze[3] = {1, 0, 0};
    double last = 0;

    paint(world, 2 * ENOUGH);
    choose(world, gaze, 42);
    send_all(world);
    choose(world, gaze, 200);
    assert_int_equal(world->count, 200);
    for (size_t i = 0; i < world->count; i++) {
        const float *centre = world->pyramid.centre[world->places[i].index];
        double angle = acos(centre[0] * gaze[0] + centre[1] * gaze[1] + centre[2] * gaze[2]);

        assert_int_equal(world->places[i].level, 0);
        /* Ordered by the nearest edge; those that hold the gaze are in no order. */
        assert_true(angle >= last - 0.08);
        last = fmax(last, angle);
    }
    /* 200 of 2048 tiles near the horizon: all within sixty degrees. */
    assert_true(last < 1.05);
}

static void the_best_few_are_the_head_of_all(void **state)
{
    struct world *world = *state;
    struct dmn_place few[50];

    paint(world, 2 * ENOUGH);
    for (size_t i = 0; i < world->pyramid.level[0].first + 700; i++)
        world->tiles[i].samples += i % 7 * ENOUGH;
    choose(world, FORWARD, 50);
    assert_int_equal(world->count, 50);
    memcpy(few, world->places, sizeof(few));
    choose(world, FORWARD, LIMIT);
    assert_true(world->count > 50);
    for (size_t i = 0; i < 50; i++) assert_int_equal(few[i].index, world->places[i].index);
    choose(world, FORWARD, 0);
    assert_int_equal(world->count, 0);
}

static void a_sparse_tile_is_sent_coarser(void **state)
{
    struct world *world = *state;

    /* A quarter of what level 0 wants is enough at level 1. */
    paint(world, ENOUGH / 4);
    send_until_done(world, FORWARD);
    assert_true(covered(world, 1));
    assert_int_equal(world->sent[0].samples, 0);
}

static void growth_sends_again_and_nothing_else_does(void **state)
{
    struct world *world = *state;

    paint(world, 2 * ENOUGH);
    send_until_done(world, FORWARD);
    world->tiles[700].samples = 3 * ENOUGH - 1;
    chooses(world, 0);
    world->tiles[700].samples = 3 * ENOUGH;
    chooses(world, 1);
    assert_int_equal(world->places[0].level, 0);
    assert_int_equal(world->places[0].index, 700);
    assert_int_equal(world->places[0].y * 64 + world->places[0].x, 700);
    send_all(world);
    chooses(world, 0);
}

/* Two tiles of level 0: at the gaze ahead, and far from it. */
enum { NEAR = 15 * 64 + 32, FAR = 15 * 64 + 10 };

/* What the eye sees of a change decides how soon it is worth a tile. */
static void a_change_that_is_not_seen_waits(void **state)
{
    struct world *world = *state;

    paint(world, 100 * ENOUGH);
    for (size_t i = 0; i < world->pyramid.level[1].first; i++) world->tiles[i].error = 0.1f;
    send_until_done(world, FORWARD);
    world->tiles[NEAR].samples = world->tiles[FAR].samples = 160 * ENOUGH;
    chooses(world, 1);
    assert_int_equal(world->places[0].index, NEAR);
    send_all(world);
    /* The noise of the other has halved; or the gaze comes there. */
    choose(world, world->pyramid.centre[FAR], LIMIT);
    assert_int_equal(world->count, 1);
    assert_int_equal(world->places[0].index, FAR);
    world->tiles[FAR].samples = 400 * ENOUGH;
    chooses(world, 1);
    assert_int_equal(world->places[0].index, FAR);
}

/* A client that cannot hold the finest levels gets all that it can hold, and its gaze is answered. */
static void no_tile_is_finer_than_the_client_holds(void **state)
{
    struct world *world = *state;
    struct dmn_place place;

    for (world->finest = 0; world->finest < LEVELS; world->finest++) {
        memset(world->sent, 0, world->pyramid.count * sizeof(*world->sent));
        paint(world, 2 * ENOUGH);
        assert_false(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));
        send_until_done(world, FORWARD);
        assert_true(covered(world, world->finest));
        for (size_t i = 0; i < world->pyramid.level[world->finest].first; i++)
            assert_int_equal(world->sent[i].samples, 0);
        /* Its finest tiles are sent again as they grow. */
        paint(world, 20 * ENOUGH);
        update(world);
        assert_true(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));
        assert_int_equal(place.level, world->finest);
        chooses(world, (uint32_t)((64 >> world->finest) * (32 >> world->finest)));
    }
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, 0), 0);
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, UINT32_MAX), 0);
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, WIDTH), 0);
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, WIDTH - 1), 1);
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, WIDTH / 8), 3);
    assert_int_equal(dmn_pyramid_finest(&world->pyramid, 1), LEVELS - 1);
}

static void a_settled_tile_is_sent_once(void **state)
{
    struct world *world = *state;

    paint(world, 100 * ENOUGH);
    for (size_t i = 0; i < world->pyramid.level[1].first; i++) world->tiles[i].error = 0;
    send_until_done(world, FORWARD);
    /* The gaze comes and goes, and with it the mark: that alone is no news. */
    world->settled[3] = true;
    chooses(world, 0);
    world->tiles[3].samples += 11 * ENOUGH;
    chooses(world, 1);
    send_all(world);
    world->tiles[3].samples += ENOUGH;
    chooses(world, 0);
    world->tiles[3].converged = true;
    chooses(world, 1);
    send_all(world);
    world->tiles[3].samples += ENOUGH;
    chooses(world, 0);
}

static void a_new_tile_goes_before_a_known_one(void **state)
{
    struct world *world = *state;

    paint(world, 2 * ENOUGH);
    send_until_done(world, FORWARD);
    /* Two tiles that touch the gaze, one of them lost to the client. */
    size_t known = 15 * 64 + 31, fresh = 15 * 64 + 32;
    world->tiles[known].samples = world->tiles[fresh].samples = 9 * ENOUGH;
    world->sent[fresh].samples = 0;
    chooses(world, 2);
    assert_int_equal(world->places[0].index, fresh);
    assert_int_equal(world->places[1].index, known);
}

/* Sums that are updated tile by tile equal those of all tiles. */
static void sums_of_what_changed(void **state)
{
    struct world *world = make(1280, 640, 4);
    struct dmn_pyramid *pyramid = &world->pyramid;
    int columns = pyramid->level[0].columns, rows = pyramid->level[0].rows;

    (void)state;
    srand(7);
    for (int turn = 0; turn < 50; turn++) {
        for (int i = 0; i < 5; i++) {
            size_t at = (size_t)(rand() % (columns * rows));

            world->tiles[at].samples = (uint64_t)(rand() % 3) * ENOUGH;
            world->tiles[at].converged = rand() % 4 > 0;
            world->tiles[at].error = (float)(rand() % 10);
            world->settled[at] = rand() % 4 > 0;
        }
        update(world);
        for (int l = 0; l < 4; l++)
            for (int y = 0; y < pyramid->level[l].rows; y++)
                for (int x = 0; x < pyramid->level[l].columns; x++) {
                    const struct dmn_tile *sum =
                        &pyramid->tile[pyramid->level[l].first + (size_t)(y * pyramid->level[l].columns + x)];
                    struct dmn_tile want = {.converged = true, .settled = true};

                    for (int r = y << l; r < (y + 1) << l && r < rows; r++)
                        for (int c = x << l; c < (x + 1) << l && c < columns; c++) {
                            want.samples += world->tiles[r * columns + c].samples;
                            want.converged &= world->tiles[r * columns + c].converged;
                            want.settled &= world->settled[r * columns + c];
                            want.error = fmaxf(want.error, world->tiles[r * columns + c].error);
                        }
                    if (l > 0 && want.samples == 0 && sum->samples == 0) continue; /* may not have been set */
                    assert_int_equal(sum->samples, want.samples);
                    assert_int_equal(sum->converged, want.converged);
                    assert_int_equal(sum->settled, want.settled);
                    assert_true(sum->error == want.error);
                }
    }
    teardown((void **)&world);
}

static void sizes_that_are_no_power_of_two(void **state)
{
    struct world *world = make(640, 320, 3);

    (void)state;
    assert_int_equal(world->pyramid.level[1].rows, 3);
    assert_int_equal(world->pyramid.level[2].columns, 3);
    assert_int_equal(world->pyramid.level[2].rows, 2);
    paint(world, ENOUGH);
    update(world);
    /* The last row of level 1 has two tiles of the film under it, not four. */
    assert_int_equal(world->pyramid.tile[world->pyramid.level[1].first + 2 * 5].samples, 2 * ENOUGH);
    send_until_done(world, FORWARD);
    assert_true(covered(world, 0));
    teardown((void **)&world);
}

static void every_film_gets_there_from_any_state(void **state)
{
    struct world *world = *state;

    /* Paths that grow as a gaze wanders, an uneven picture, a slow client: at the end all is shown. */
    srand(1);
    for (int round = 0; round < 40; round++) {
        float gaze[3];

        rnd_direction((float)rand() / (float)RAND_MAX * 6 - 3, (float)rand() / (float)RAND_MAX * 3 - 1.5f,
                      gaze);
        for (int i = 0; i < 2048; i++)
            if (rand() % 4 == 0) world->tiles[i].samples += (uint64_t)rand() % (3 * ENOUGH);
        choose(world, gaze, 8);
        for (size_t i = 1; i < world->count; i++)
            assert_true(world->places[i].rank >= world->places[i - 1].rank);
        send_all(world);
        /* Once the two coarsest went, nothing is ever black. */
        if (round > 4) assert_true(covered(world, LEVELS - 1));
    }
    paint(world, 1000 * ENOUGH);
    send_until_done(world, FORWARD);
    assert_true(covered(world, 0));
}

static void every_direction_falls_into_its_tile(void **state)
{
    struct world *world = *state;
    size_t columns = (size_t)world->pyramid.level[0].columns,
           count = columns * (size_t)world->pyramid.level[0].rows;

    for (size_t i = 0; i < count; i++)
        assert_int_equal(dmn_pyramid_at(&world->pyramid, world->pyramid.centre[i]), i);
    /* Poles, and both sides of the seam. */
    assert_true(dmn_pyramid_at(&world->pyramid, (const float[3]){0, 1, 0}) < columns);
    assert_true(dmn_pyramid_at(&world->pyramid, (const float[3]){0, -1.0001f, 0}) >= count - columns);
    assert_int_equal(dmn_pyramid_at(&world->pyramid, (const float[3]){0, 0.01f, 1}) % columns, 0);
    assert_int_equal(dmn_pyramid_at(&world->pyramid, (const float[3]){-0.01f, 0.01f, 1}) % columns, 0);
    assert_int_equal(dmn_pyramid_at(&world->pyramid, (const float[3]){0.01f, 0.01f, 1}) % columns,
                     columns - 1);
}

static void what_the_eye_sees_is_the_finest_that_was_sent(void **state)
{
    struct world *world = *state;
    size_t columns = (size_t)world->pyramid.level[0].columns, fine = dmn_pyramid_at(&world->pyramid, FORWARD),
           coarse;
    struct dmn_place place;

    /* A client that has nothing sees nothing. */
    paint(world, DMN_OUTLINE_PATHS);
    update(world);
    assert_false(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));

    /* It is sent the coarse levels: their finest is seen, and has nothing new until there are more paths. */
    send_until_done(world, FORWARD);
    assert_false(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));
    world->tiles[fine].samples++;
    update(world);
    assert_true(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));
    assert_int_equal(place.level, 4);
    coarse = world->pyramid.level[4].first + (fine / columns >> 4) * (columns >> 4) + (fine % columns >> 4);
    assert_int_equal(place.index, coarse);

    /* Then the fine one, which one more path does not make worth sending for itself. */
    paint(world, 10 * ENOUGH);
    choose(world, FORWARD, LIMIT);
    send_until_done(world, FORWARD);
    world->tiles[fine].samples++;
    chooses(world, 0);
    assert_true(dmn_seen_at(&world->pyramid, world->sent, FORWARD, world->finest, &place));
    assert_int_equal(place.level, 0);
    assert_int_equal(place.index, fine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_painted_nothing_sent, setup, teardown),
        cmocka_unit_test_setup_teardown(an_outline_is_sent_coarsest_first_and_whole, setup, teardown),
        cmocka_unit_test_setup_teardown(a_fine_picture_ends_fine_everywhere, setup, teardown),
        cmocka_unit_test_setup_teardown(finer_tiles_follow_the_gaze, setup, teardown),
        cmocka_unit_test_setup_teardown(the_best_few_are_the_head_of_all, setup, teardown),
        cmocka_unit_test_setup_teardown(a_sparse_tile_is_sent_coarser, setup, teardown),
        cmocka_unit_test_setup_teardown(growth_sends_again_and_nothing_else_does, setup, teardown),
        cmocka_unit_test_setup_teardown(a_change_that_is_not_seen_waits, setup, teardown),
        cmocka_unit_test_setup_teardown(no_tile_is_finer_than_the_client_holds, setup, teardown),
        cmocka_unit_test_setup_teardown(a_settled_tile_is_sent_once, setup, teardown),
        cmocka_unit_test_setup_teardown(a_new_tile_goes_before_a_known_one, setup, teardown),
        cmocka_unit_test(sums_of_what_changed),
        cmocka_unit_test(sizes_that_are_no_power_of_two),
        cmocka_unit_test_setup_teardown(every_film_gets_there_from_any_state, setup, teardown),
        cmocka_unit_test_setup_teardown(every_direction_falls_into_its_tile, setup, teardown),
        cmocka_unit_test_setup_teardown(what_the_eye_sees_is_the_finest_that_was_sent, setup, teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
