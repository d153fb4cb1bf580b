/* The client's picture: the finest level wins, coarse levels are interpolated, and generations end. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"

static struct pro_picture *create(uint32_t width, uint32_t height, uint32_t tile_size, uint32_t levels)
{
    Fovea__Welcome welcome = FOVEA__WELCOME__INIT;
    char error[PRO_ERROR_SIZE];
    welcome.width = width;
    welcome.height = height;
    welcome.tile_size = tile_size;
    welcome.levels = levels;
    welcome.generation = 5;
    return pro_picture_create(&welcome, error);
}

/* Put a tile of one value in red, and 2 and 3 times that value in green and blue. */
static void put_flat(struct pro_picture *picture, uint64_t generation, uint32_t level, uint32_t x, uint32_t y,
                     uint32_t size, float value)
{
    float *rgb = malloc((size_t)size * size * 3 * sizeof *rgb);
    for (size_t i = 0; i < (size_t)size * size * 3; i++) rgb[i] = value * (float)(i % 3 + 1);
    assert_true(pro_picture_has_place(picture, level, x, y));
    assert_true(pro_picture_put(picture, generation, level, x, y, rgb));
    free(rgb);
}

static void nothing_came(void **state)
{
    (void)state;
    struct pro_picture *picture = create(64, 32, 16, 2);
    static float rgb[64 * 32 * 3];
    memset(rgb, 0x7f, sizeof rgb);
    pro_picture_resolve(picture, rgb);
    for (size_t i = 0; i < sizeof rgb / sizeof *rgb; i++) assert_true(rgb[i] == 0);
    assert_true(pro_picture_coverage(picture) == 0);
    pro_picture_destroy(picture);
    pro_picture_destroy(NULL);
}

static void finest_wins(void **state)
{
    (void)state;
    struct pro_picture *picture = create(64, 32, 16, 2); /* 4 x 2 tiles, then 2 x 1 */
    static float rgb[64 * 32 * 3];
    put_flat(picture, 5, 0, 1, 0, 16, 3);
    assert_true(pro_picture_coverage(picture) == 1 / 8.0);
    put_flat(picture, 5, 1, 0, 0, 16, 8); /* late and coarse: fills what the fine tile leaves empty */
    assert_true(pro_picture_coverage(picture) == 4 / 8.0);
    put_flat(picture, 5, 0, 1, 0, 16, 4); /* a newer tile replaces it */
    pro_picture_resolve(picture, rgb);
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 64; x++) {
            float expected = x >= 32 ? 0 : x >= 16 && y < 16 ? 4 : 8;
            for (int c = 0; c < 3; c++) assert_true(rgb[(y * 64 + x) * 3 + c] == expected * (float)(c + 1));
        }
    put_flat(picture, 5, 1, 1, 0, 16, 1);
    assert_true(pro_picture_coverage(picture) == 1);
    pro_picture_destroy(picture);
}

static void generations(void **state)
{
    (void)state;
    struct pro_picture *picture = create(64, 32, 16, 2);
    static float rgb[64 * 32 * 3];
    put_flat(picture, 5, 1, 0, 0, 16, 8);
    put_flat(picture, 4, 1, 1, 0, 16, 9); /* an old generation: dropped */
    assert_true(pro_picture_coverage(picture) == 0.5);
    put_flat(picture, 6, 0, 3, 1, 16, 2); /* a new generation empties the rest */
    assert_true(pro_picture_coverage(picture) == 1 / 8.0);
    pro_picture_resolve(picture, rgb);
    assert_true(rgb[0] == 0);
    assert_true(rgb[(31 * 64 + 63) * 3] == 2);
    put_flat(picture, 5, 1, 0, 0, 16, 8);
    assert_true(pro_picture_coverage(picture) == 1 / 8.0);
    pro_picture_destroy(picture);
}

/* Computed by hand: two adjacent pixels of level 2 are four film pixels apart. */
static void bilinear_by_hand(void **state)
{
    (void)state;
    struct pro_picture *picture = create(64, 32, 8, 3); /* level 2: 16 x 8, in 2 x 1 tiles */
    static float rgb[64 * 32 * 3];
    put_flat(picture, 5, 2, 0, 0, 8, 10);
    pro_picture_resolve(picture, rgb);
    for (int x = 0; x < 32; x++) assert_true(rgb[x * 3] == 10); /* a single tile is flat up to its border */
    put_flat(picture, 5, 2, 1, 0, 8, 18);
    pro_picture_resolve(picture, rgb);
    const float across[] = {10, 10, 11, 13,
                            15, 17, 18, 18}; /* columns 28 to 35: steps of 8/4 around the border */
    const float seam[] = {18, 18, 17, 15, 13, 11, 10, 10}; /* columns 60 to 63, then 0 to 3 */
    for (int i = 0; i < 8; i++) {
        for (int y = 0; y < 32; y += 31) {
            assert_true(rgb[(y * 64 + 28 + i) * 3] == across[i]);
            assert_true(rgb[(y * 64 + (60 + i) % 64) * 3] == seam[i]);
        }
    }
    pro_picture_destroy(picture);
}

/* --- random pictures, compared with the definition pixel by pixel --- */

enum { LEVELS = 5 };

struct model {
    int width[LEVELS], height[LEVELS], columns[LEVELS], rows[LEVELS];
    int size, levels;
    bool *came[LEVELS];
    float *red[LEVELS];
};

static int at_most(int a, int b)
{
    return a < b ? a : b;
}

static float tap(const struct model *m, int l, int home_x, int home_y, int x, int y)
{
    int size = m->size, wrapped = ((x % m->width[l]) + m->width[l]) % m->width[l];
    y = y < 0 ? 0 : at_most(y, m->height[l] - 1);
    if (m->came[l][y / size * m->columns[l] + wrapped / size]) return m->red[l][y * m->width[l] + wrapped];
    x = x < home_x * size ? home_x * size : at_most(x, at_most((home_x + 1) * size, m->width[l]) - 1);
    y = y < home_y * size ? home_y * size : at_most(y, at_most((home_y + 1) * size, m->height[l]) - 1);
    return m->red[l][y * m->width[l] + x];
}

static float expected(const struct model *m, int px, int py)
{
    for (int l = 0; l < m->levels; l++) {
        int home_x = (px >> l) / m->size, home_y = (py >> l) / m->size;
        if (!m->came[l][home_y * m->columns[l] + home_x]) continue;
        double u = (px + 0.5) / (1 << l) - 0.5, v = (py + 0.5) / (1 << l) - 0.5;
        int x = (int)floor(u), y = (int)floor(v);
        double s = u - x, t = v - y;
        return (float)((1 - t) * ((1 - s) * tap(m, l, home_x, home_y, x, y) +
                                  s * tap(m, l, home_x, home_y, x + 1, y)) +
                       t * ((1 - s) * tap(m, l, home_x, home_y, x, y + 1) +
                            s * tap(m, l, home_x, home_y, x + 1, y + 1)));
    }
    return 0;
}

static unsigned dice(unsigned *seed)
{
    return (*seed = *seed * 1664525 + 1013904223) >> 16;
}

static void compare(int width, int height, int size, int levels, unsigned seed, unsigned percent)
{
    struct model m = {.size = size, .levels = levels};
    struct pro_picture *picture = create((uint32_t)width, (uint32_t)height, (uint32_t)size, (uint32_t)levels);
    assert_non_null(picture);
    float *tile = malloc((size_t)(size * size * 3) * sizeof *tile);
    for (int l = levels - 1; l >= 0; l--) {
        m.width[l] = (width + (1 << l) - 1) >> l;
        m.height[l] = (height + (1 << l) - 1) >> l;
        m.columns[l] = (m.width[l] + size - 1) / size;
        m.rows[l] = (m.height[l] + size - 1) / size;
        m.came[l] = calloc((size_t)(m.columns[l] * m.rows[l]), sizeof **m.came);
        m.red[l] = calloc((size_t)(m.width[l] * m.height[l]), sizeof **m.red);
        for (int t = 0; t < m.columns[l] * m.rows[l]; t++) {
            if (dice(&seed) % 100 >= percent) continue;
            int x0 = t % m.columns[l] * size, y0 = t / m.columns[l] * size;
            m.came[l][t] = true;
            for (int i = 0; i < size * size; i++) {
                int x = x0 + i % size, y = y0 + i / size;
                float red = (float)(dice(&seed) % 256);
                bool inside = x < m.width[l] && y < m.height[l];
                if (inside) m.red[l][y * m.width[l] + x] = red;
                tile[3 * i] = inside ? red : 60000; /* pixels beyond the level must not show */
                tile[3 * i + 1] = tile[3 * i + 2] = -1;
            }
            assert_true(pro_picture_put(picture, 5, (uint32_t)l, (uint32_t)(t % m.columns[l]),
                                        (uint32_t)(t / m.columns[l]), tile));
        }
        assert_true(
            pro_picture_has_place(picture, (uint32_t)l, (uint32_t)m.columns[l] - 1, (uint32_t)m.rows[l] - 1));
        assert_false(pro_picture_has_place(picture, (uint32_t)l, (uint32_t)m.columns[l], 0));
        assert_false(pro_picture_has_place(picture, (uint32_t)l, 0, (uint32_t)m.rows[l]));
    }
    float *rgb = malloc((size_t)(width * height * 3) * sizeof *rgb);
    pro_picture_resolve(picture, rgb);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float wanted = expected(&m, x, y), got = rgb[(y * width + x) * 3];
            if (fabsf(got - wanted) > 0.01f) fail_msg("%d, %d: %g, expected %g", x, y, got, wanted);
        }
    for (int l = 0; l < levels; l++) {
        free(m.came[l]);
        free(m.red[l]);
    }
    free(rgb);
    free(tile);
    pro_picture_destroy(picture);
}

static void as_defined(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 20; seed++) {
        compare(64, 32, 8, 3, seed, 40);
        compare(56, 40, 8, 4, seed, 30); /* the last tiles of levels overhang */
        compare(24, 24, 3, 5, seed, 25); /* coarse pixels are wider than a tile */
        compare(512, 256, 256, 5, seed, 50);
        compare(8, 4, 4, 3, seed, 60);
    }
}

static void films_that_are_refused(void **state)
{
    (void)state;
    static const uint32_t absurd[][4] = {
        /* width, height, tile size, levels */
        {0, 0, 64, 1},        {0, 64, 64, 1},          {64, 0, 64, 1},
        {65600, 64, 64, 1},   {64, 4294967232, 64, 1}, {65536, 65536, 256, 1}, /* too many pixels */
        {32768, 16384, 8, 1},                                                  /* too many tiles */
        {128, 64, 0, 1},      {128, 64, 48, 1},        {1024, 512, 512, 1},
        {128, 64, 64, 0},     {128, 64, 64, 8},        {128, 64, 64, 4294967295},
    };
    for (size_t i = 0; i < sizeof absurd / sizeof *absurd; i++) {
        const uint32_t *a = absurd[i];
        assert_null(create(a[0], a[1], a[2], a[3]));
    }
    struct pro_picture *largest = create(32768, 16384, 64, 9), *deepest = create(128, 64, 64, 7);
    assert_non_null(largest);
    assert_non_null(deepest);
    pro_picture_destroy(largest);
    pro_picture_destroy(deepest);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_came), cmocka_unit_test(finest_wins),
        cmocka_unit_test(generations),  cmocka_unit_test(bilinear_by_hand),
        cmocka_unit_test(as_defined),   cmocka_unit_test(films_that_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
