/* Tile encodings: round trips, values that an encoding cannot hold, and bytes that are no tile. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <zstd.h>

#include "encoding/half.h"
#include "protocol.h"

#define HALF_ZSTD FOVEA__ENCODING__ENCODING_HALF_ZSTD
#define JPEG      FOVEA__ENCODING__ENCODING_JPEG
#define RGB9E5    FOVEA__ENCODING__ENCODING_RGB9E5

enum { SIZE = 64, VALUES = SIZE * SIZE * 3 };

/* The value of a half by its definition (IEEE 754-2008, 3.4). */
static double half_by_definition(unsigned half)
{
    int exponent = half >> 10 & 31;
    double fraction = half & 1023;
    double size = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return half & 0x8000 ? -size : size;
}

static void every_half(void **state)
{
    (void)state;
    for (unsigned half = 0; half < 65536; half++) {
        assert_int_equal(half_is_finite((uint16_t)half), (half & 0x7fff) < 0x7c00);
        if (!half_is_finite((uint16_t)half)) continue;
        float value = half_to_float((uint16_t)half);
        assert_true(value == half_by_definition(half));
        assert_int_equal(half_from_float(value), half);
        if ((half & 0x7fff) == 0x7bff) continue;
        /* A value between this half and the next goes to the nearer one; the middle goes to the even one. */
        double next = half_by_definition(half + 1), middle = (value + next) / 2;
        assert_int_equal(half_from_float((float)middle), half + (half & 1));
        assert_int_equal(half_from_float(nextafterf((float)middle, value)), half);
        assert_int_equal(half_from_float(nextafterf((float)middle, (float)next)), half + 1);
    }
}

/* Encode and decode a tile whose values are 1, except one of them. */
static float through(float value)
{
    static float rgb[VALUES], back[VALUES];
    for (int i = 0; i < VALUES; i++) rgb[i] = 1;
    rgb[VALUES - 1] = value;
    size_t count;
    uint8_t *bytes = pro_encode(HALF_ZSTD, rgb, SIZE, &count);
    assert_non_null(bytes);
    assert_true(pro_decode(HALF_ZSTD, bytes, count, SIZE, back));
    free(bytes);
    assert_true(back[0] == 1 && back[VALUES - 2] == 1);
    return back[VALUES - 1];
}

static void numbers_beyond_a_half(void **state)
{
    (void)state;
    assert_true(through(INFINITY) == 65504);
    assert_true(through(-INFINITY) == -65504);
    assert_true(through(1e9f) == 65504);
    assert_true(through(65519.996f) == 65504);
    assert_true(through(NAN) == 0);
    assert_true(through(-NAN) == 0);
    assert_true(through(-0.5f) == -0.5f);
    assert_true(through(0x1p-24f) == 0x1p-24f);
    assert_true(through(0x1p-26f) == 0);
}

static void half_zstd_is_lossless(void **state)
{
    (void)state;
    static const unsigned sizes[] = {1, 7, 64, 256};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        size_t values = (size_t)sizes[s] * sizes[s] * 3, count;
        float *rgb = malloc(values * sizeof *rgb), *back = malloc(values * sizeof *back);
        for (size_t i = 0; i < values; i++)
            rgb[i] = (float)half_by_definition((unsigned)(i * 2654435761u) % 0x7c00);
        uint8_t *bytes = pro_encode(HALF_ZSTD, rgb, sizes[s], &count);
        assert_non_null(bytes);
        assert_true(pro_decode(HALF_ZSTD, bytes, count, sizes[s], back));
        assert_memory_equal(rgb, back, values * sizeof *rgb);
        free(bytes);
        free(rgb);
        free(back);
    }
}

/* Decode from a copy of exactly this size, so that a sanitizer notices any access beyond it. */
static bool decode_copy(Fovea__Encoding encoding, const uint8_t *bytes, size_t count, unsigned size)
{
    uint8_t *copy = malloc(count ? count : 1);
    float *rgb = malloc((size_t)size * size * 3 * sizeof *rgb);
    memcpy(copy, bytes, count);
    bool ok = pro_decode(encoding, copy, count, size, rgb);
    free(copy);
    free(rgb);
    return ok;
}

static uint8_t *encode_gradient(Fovea__Encoding encoding, unsigned size, size_t *out_count)
{
    float *rgb = malloc((size_t)size * size * 3 * sizeof *rgb);
    for (unsigned i = 0; i < size * size; i++) {
        rgb[3 * i] = (float)(i % size) / (float)size;
        rgb[3 * i + 1] = (float)(i / size) / (float)size;
        rgb[3 * i + 2] = 0.25f;
    }
    uint8_t *bytes = pro_encode(encoding, rgb, size, out_count);
    assert_non_null(bytes);
    free(rgb);
    return bytes;
}

/* For every encoding: a wrong size, data cut short, data with extra bytes, and damage at every byte. */
static void spoilt(Fovea__Encoding encoding)
{
    size_t count;
    uint8_t *bytes = encode_gradient(encoding, 16, &count);
    assert_true(decode_copy(encoding, bytes, count, 16));
    assert_false(decode_copy(encoding, bytes, count, 15));
    assert_false(decode_copy(encoding, bytes, count, 32));
    assert_false(decode_copy(encoding, bytes, count, 1));
    assert_false(decode_copy(encoding, bytes, 0, 16));
    for (size_t cut = 1; cut < count; cut++) assert_false(decode_copy(encoding, bytes, count - cut, 16));
    uint8_t *longer = malloc(count + 1);
    memcpy(longer, bytes, count);
    longer[count] = 0;
    assert_false(decode_copy(encoding, longer, count + 1, 16));
    free(longer);
    for (size_t at = 0; at < count; at++) {
        bytes[at] ^= 0x55;
        decode_copy(encoding, bytes, count, 16); /* may decode to other pixels; must only be safe */
        bytes[at] ^= 0x55;
    }
    uint64_t seed = 1;
    for (int i = 0; i < 5000; i++) {
        uint8_t garbage[100];
        for (size_t b = 0; b < sizeof garbage; b++)
            garbage[b] = (uint8_t)((seed = seed * 6364136223846793005u + 1442695040888963407u) >> 56);
        /* Half of them begin like a real tile. */
        if (i % 2) memcpy(garbage, bytes, 8);
        assert_false(decode_copy(encoding, garbage, sizeof garbage, 16));
    }
    free(bytes);
}

static void half_zstd_spoilt(void **state)
{
    (void)state;
    spoilt(HALF_ZSTD);
}

static void jpeg_spoilt(void **state)
{
    (void)state;
    spoilt(JPEG);
}

static void assert_not_a_tile(const void *pixels, size_t size,
                              size_t (*wrap)(void *, size_t, const void *, size_t))
{
    size_t bound = ZSTD_compressBound(size) + 64;
    uint8_t *bytes = malloc(bound);
    size_t count = wrap(bytes, bound, pixels, size);
    assert_true(count > 0 && count <= bound);
    assert_false(decode_copy(HALF_ZSTD, bytes, count, SIZE));
    free(bytes);
}

static size_t wrap_plain(void *out, size_t room, const void *in, size_t size)
{
    return ZSTD_compress(out, room, in, size, 1);
}

/* Compressed as a stream: its frame does not state the size of the content. */
static size_t wrap_without_size(void *out, size_t room, const void *in, size_t size)
{
    ZSTD_CCtx *context = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
    size_t count = ZSTD_compress2(context, out, room, in, size);
    ZSTD_freeCCtx(context);
    return count;
}

/* A frame that claims to hold 2^60 bytes. */
static size_t wrap_bomb(void *out, size_t room, const void *in, size_t size)
{
    (void)in, (void)size;
    const uint8_t bytes[] = {0x28, 0xb5, 0x2f, 0xfd, 0xc0, 0x00, 0, 0, 0, 0, 0, 0, 0, 0x10, 0x03, 0, 0x10, 0};
    assert_true(sizeof bytes <= room);
    memcpy(out, bytes, sizeof bytes);
    return sizeof bytes;
}

/* A frame that states the right size but holds much more: run-length blocks, each of 128 KiB in 4 bytes. */
static size_t wrap_liar(void *out, size_t room, const void *in, size_t size)
{
    (void)in;
    uint8_t *bytes = out;
    const uint8_t head[] = {
        0x28, 0xb5, 0x2f, 0xfd, 0xa0, (uint8_t)size, (uint8_t)(size >> 8), (uint8_t)(size >> 16), 0};
    memcpy(bytes, head, sizeof head);
    size_t count = sizeof head;
    while (count + 4 <= room && count < 64) {
        uint32_t block = 128 << 10 << 3 | 1 << 1 | (count + 4 >= 64);
        memcpy(bytes + count, (uint8_t[]){(uint8_t)block, (uint8_t)(block >> 8), (uint8_t)(block >> 16), 7},
               4);
        count += 4;
    }
    return count;
}

static size_t wrap_two(void *out, size_t room, const void *in, size_t size)
{
    size_t first = ZSTD_compress(out, room, in, size, 1);
    return first + ZSTD_compress((uint8_t *)out + first, room - first, "", 0, 1);
}

static void half_zstd_wrong_inside(void **state)
{
    (void)state;
    static uint16_t halves[VALUES];
    for (int i = 0; i < VALUES; i++) halves[i] = 0x3c00;
    uint8_t bytes[1000];
    size_t count = ZSTD_compress(bytes, sizeof bytes, halves, sizeof halves, 1);
    assert_true(decode_copy(HALF_ZSTD, bytes, count, SIZE));

    assert_not_a_tile(halves, sizeof halves - 2, wrap_plain);
    assert_not_a_tile(halves, sizeof halves, wrap_without_size);
    assert_not_a_tile(halves, sizeof halves, wrap_bomb);
    assert_not_a_tile(halves, sizeof halves, wrap_liar);
    assert_not_a_tile(halves, sizeof halves, wrap_two);
    halves[VALUES / 2] = 0x7c00; /* infinite */
    assert_not_a_tile(halves, sizeof halves, wrap_plain);
    halves[VALUES / 2] = 0xfe00; /* NaN */
    assert_not_a_tile(halves, sizeof halves, wrap_plain);
}

static double srgb(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

/* A tile of one value: only the sRGB curve and the rounding to eight bits can change it. */
static void jpeg_flat(void **state)
{
    (void)state;
    static float rgb[VALUES], back[VALUES];
    for (int step = 0; step <= 200; step++) {
        float value = (float)pow(step / 200.0, 3);
        size_t count;
        for (int i = 0; i < VALUES; i++) rgb[i] = value;
        uint8_t *bytes = pro_encode(JPEG, rgb, SIZE, &count);
        assert_non_null(bytes);
        assert_true(pro_decode(JPEG, bytes, count, SIZE, back));
        free(bytes);
        double wanted = 255 * srgb(value), got = 255 * srgb(back[0]);
        /* Half a step of eight bits. The one coefficient is quantised to 3/8 of a step, which rounding
         * removes. */
        assert_true(fabs(got - wanted) <= 0.51);
        assert_memory_equal(back, back + 3, (VALUES - 3) * sizeof *back);
    }
}

static void jpeg_gradient(void **state)
{
    (void)state;
    static float rgb[VALUES], back[VALUES];
    for (int i = 0; i < SIZE * SIZE; i++) {
        rgb[3 * i] = powf((float)(i % SIZE) / SIZE, 2.2f);
        rgb[3 * i + 1] = powf((float)(i / SIZE) / SIZE, 2.2f);
        rgb[3 * i + 2] = 0.2f;
    }
    size_t count;
    uint8_t *bytes = pro_encode(JPEG, rgb, SIZE, &count);
    assert_non_null(bytes);
    assert_true(pro_decode(JPEG, bytes, count, SIZE, back));
    free(bytes);
    double sum = 0, worst = 0;
    for (int i = 0; i < VALUES; i++) {
        double error = fabs(255 * (srgb(back[i]) - srgb(rgb[i])));
        sum += error;
        if (error > worst) worst = error;
    }
    assert_true(sum / VALUES < 1.5);
    assert_true(worst < 8);
}

static void jpeg_numbers_beyond(void **state)
{
    (void)state;
    static float rgb[VALUES], back[VALUES];
    const float values[] = {INFINITY, 1e30f, 1, NAN, -INFINITY, -1, 0};
    for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
        for (int i = 0; i < VALUES; i++) rgb[i] = values[v];
        size_t count;
        uint8_t *bytes = pro_encode(JPEG, rgb, SIZE, &count);
        assert_non_null(bytes);
        assert_true(pro_decode(JPEG, bytes, count, SIZE, back));
        free(bytes);
        for (int i = 0; i < VALUES; i++) assert_true(back[i] == (values[v] > 0 ? 1 : 0));
    }
}

static void rgb9e5_spoilt(void **state)
{
    (void)state;
    spoilt(RGB9E5);
}

/* Encode one pixel, and return its word. */
static uint32_t rgb9e5_word(float r, float g, float b)
{
    const float rgb[3] = {r, g, b};
    size_t count;
    uint8_t *bytes = pro_encode(RGB9E5, rgb, 1, &count);
    assert_int_equal(count, 4);
    const uint32_t word =
        bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
    free(bytes);
    return word;
}

/* Words by the definition of EXT_texture_shared_exponent: red in the lowest bits, exponent in the highest. */
static void rgb9e5_words(void **state)
{
    (void)state;
    assert_int_equal(rgb9e5_word(0, 0, 0), 0);
    assert_int_equal(rgb9e5_word(1, 0.5f, 0.25f), 16u << 27 | 64u << 18 | 128u << 9 | 256);
    assert_int_equal(rgb9e5_word(65408, 0, 0), 31u << 27 | 511);
    assert_int_equal(rgb9e5_word(1e9f, INFINITY, 0), 31u << 27 | 511u << 9 | 511);
    assert_int_equal(rgb9e5_word(NAN, -1, -INFINITY), 0);
    assert_int_equal(rgb9e5_word(0x1p-24f, 0, 0), 1);
    assert_int_equal(rgb9e5_word(0.9999f, 0, 0),
                     16u << 27 | 256); /* its mantissa rounds up to the next exponent */
}

/* Values that the format can hold come back exactly; others within half a step of the largest channel. */
static void rgb9e5_round_trip(void **state)
{
    (void)state;
    static float rgb[VALUES], back[VALUES];
    uint64_t seed = 9;
    size_t count;
    for (int i = 0; i < VALUES; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        rgb[i] = ldexpf((float)(seed >> 40) * 0x1p-24f, (int)(seed >> 32 & 31) - 15);
    }
    uint8_t *bytes = pro_encode(RGB9E5, rgb, SIZE, &count);
    assert_int_equal(count, 4 * SIZE * SIZE);
    assert_true(pro_decode(RGB9E5, bytes, count, SIZE, back));
    for (int i = 0; i < VALUES; i += 3) {
        const float most = fmaxf(rgb[i], fmaxf(rgb[i + 1], rgb[i + 2]));
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(back[i + c] - rgb[i + c]) <= fmaxf(most * 0x1p-9f, 0x1p-25f));
    }
    uint8_t *again = pro_encode(RGB9E5, back, SIZE, &count);
    assert_memory_equal(again, bytes, count);
    free(bytes);
    free(again);
}

/* A JPEG that is a valid picture, but not a tile, is refused. */
static void assert_jpeg_refused(int width, int height, int channels, bool progressive)
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    uint8_t *bytes = NULL;
    unsigned long count = 0;
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &count);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = channels;
    jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    if (progressive) jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    uint8_t *row = calloc((size_t)width, (size_t)channels);
    while (jpeg.next_scanline < (JDIMENSION)height) jpeg_write_scanlines(&jpeg, &row, 1);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_false(decode_copy(JPEG, bytes, count, SIZE));
    free(row);
    free(bytes);
}

static void jpeg_wrong_kind(void **state)
{
    (void)state;
    assert_jpeg_refused(SIZE, SIZE - 1, 3, false);
    assert_jpeg_refused(SIZE + 1, SIZE, 3, false);
    assert_jpeg_refused(4000, 10, 3, false);
    assert_jpeg_refused(SIZE, SIZE, 1, false);
    assert_jpeg_refused(SIZE, SIZE, 4, false);
    assert_jpeg_refused(SIZE, SIZE, 3, true);
}

static void unknown_encoding_or_size(void **state)
{
    (void)state;
    size_t count;
    static float rgb[257 * 257 * 3];
    assert_null(pro_encode(FOVEA__ENCODING__ENCODING_NONE, rgb, SIZE, &count));
    assert_null(pro_encode((Fovea__Encoding)99, rgb, SIZE, &count));
    assert_null(pro_encode(HALF_ZSTD, rgb, 0, &count));
    assert_null(pro_encode(HALF_ZSTD, rgb, 257, &count));
    assert_null(pro_encode(JPEG, rgb, 257, &count));
    assert_false(pro_decode(FOVEA__ENCODING__ENCODING_NONE, (const uint8_t *)"", 0, SIZE, rgb));
    assert_false(pro_decode((Fovea__Encoding)-1, (const uint8_t *)"x", 1, SIZE, rgb));
    assert_false(pro_decode(HALF_ZSTD, (const uint8_t *)"x", 1, 0, rgb));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_half),
        cmocka_unit_test(numbers_beyond_a_half),
        cmocka_unit_test(half_zstd_is_lossless),
        cmocka_unit_test(half_zstd_spoilt),
        cmocka_unit_test(half_zstd_wrong_inside),
        cmocka_unit_test(jpeg_flat),
        cmocka_unit_test(jpeg_gradient),
        cmocka_unit_test(jpeg_numbers_beyond),
        cmocka_unit_test(jpeg_spoilt),
        cmocka_unit_test(jpeg_wrong_kind),
        cmocka_unit_test(rgb9e5_round_trip),
        cmocka_unit_test(rgb9e5_spoilt),
        cmocka_unit_test(rgb9e5_words),
        cmocka_unit_test(unknown_encoding_or_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
