/* Tiles that clients share: each is read and encoded once, until the picture has a newer one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "encode.h"

/* What the renderer has, and how often it was read. */
static struct rnd_tile there = {.samples = 100, .generation = 1};
static bool is_locked;
static int reads;

bool __wrap_rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                            struct rnd_tile *out_state);
bool __wrap_rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                            struct rnd_tile *out_state)
{
    (void)render, (void)level, (void)y;
    reads++;
    if (is_locked) return false;
    for (int i = 0; i < RND_TILE * RND_TILE * 3; i++) out_rgb[i] = (float)(there.samples + (uint64_t)x);
    *out_state = there;
    return true;
}

static struct dmn_tile known[DMN_ENCODED + 1];
static struct dmn_picture picture = {.generation = 1, .pyramid.tile = known};
static struct dmn_encoder encoder;

/* The number that the tile's pixels have, by any client. */
static float get(size_t index, Fovea__Encoding encoding, int reads_expected)
{
    const struct dmn_place place = {.x = (int)index, .index = index};
    static float rgb[RND_TILE * RND_TILE * 3];
    const struct dmn_encoded *encoded;

    reads = 0;
    encoded = dmn_encode(&encoder, &picture, &place, encoding);
    assert_int_equal(reads, reads_expected);
    assert_non_null(encoded);
    assert_int_equal(encoded->read.samples, there.samples);
    assert_true(pro_decode(encoding, encoded->bytes, encoded->count, RND_TILE, rgb));
    return rgb[0];
}

static void shared(void **state)
{
    const Fovea__Encoding half = FOVEA__ENCODING__ENCODING_HALF_ZSTD, e5 = FOVEA__ENCODING__ENCODING_RGB9E5;
    const struct dmn_place first = {.index = 0};

    (void)state;
    known[0].samples = known[1].samples = 100;
    assert_float_equal(get(0, half, 1), 100, 0);
    assert_float_equal(get(0, half, 0), 100, 0);
    assert_float_equal(get(0, e5, 1), 100, 0);
    assert_float_equal(get(1, half, 1), 101, 0);
    assert_float_equal(get(0, half, 0), 100, 0);
    /* The picture knows of more paths; then of another generation, which has as many. */
    there.samples = known[0].samples = 200;
    assert_float_equal(get(0, half, 1), 200, 0);
    picture.generation = there.generation = 2;
    assert_float_equal(get(0, half, 1), 200, 0);
    assert_float_equal(get(0, half, 0), 200, 0);
    /* Another tile in its place. */
    known[DMN_ENCODED].samples = 200;
    assert_float_equal(get(DMN_ENCODED, half, 1), 200 + DMN_ENCODED, 0);
    assert_float_equal(get(0, half, 1), 200, 0);
    /* A tile that cannot be read now is read again. */
    is_locked = true;
    known[0].samples = 300;
    assert_null(dmn_encode(&encoder, &picture, &first, half));
    is_locked = false;
    there.samples = 300;
    assert_float_equal(get(0, half, 1), 300, 0);
    dmn_encoder_finish(&encoder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shared)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
