/* Which tiles are worth sending again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "grown.h"

enum { COUNT = 6 };

static const struct dmn_tile TILE[COUNT] = {{.samples = 100}, {.samples = 160}, {.samples = 4000},
                                            {.samples = 0},   {.samples = 300}, {.samples = 101}};
static const uint64_t SENT[COUNT] = {100, 100, 0, 0, 100, 100};

static void those_that_have_grown_most_come_first(void **state)
{
    uint32_t index[COUNT];

    (void)state;
    assert_int_equal(dmn_grown(TILE, SENT, COUNT, 1.5, COUNT, index), 3);
    assert_int_equal(index[0], 2); /* it was never sent */
    assert_int_equal(index[1], 4);
    assert_int_equal(index[2], 1);
    assert_int_equal(dmn_grown(TILE, SENT, COUNT, 1, COUNT, index), 4);
    assert_int_equal(index[3], 5);
}

static void no_more_than_asked_for(void **state)
{
    uint32_t index[COUNT] = {0, 0, 77};

    (void)state;
    assert_int_equal(dmn_grown(TILE, SENT, COUNT, 1, 2, index), 2);
    assert_int_equal(index[0], 2);
    assert_int_equal(index[1], 4);
    assert_int_equal(index[2], 77);
    assert_int_equal(dmn_grown(TILE, SENT, COUNT, 1, 0, index), 0);
}

/* Sending what is told, over and over, ends with everything sent. */
static void all_are_told_in_the_end(void **state)
{
    enum { MANY = 500 };
    struct dmn_tile tile[MANY];
    uint64_t sent[MANY] = {0};
    uint32_t index[7];
    size_t rounds = 0, found;

    (void)state;
    for (size_t i = 0; i < MANY; i++) tile[i] = (struct dmn_tile){.samples = i * 7919 % 1000};
    while ((found = dmn_grown(tile, sent, MANY, 1, 7, index)) > 0) {
        for (size_t i = 0; i < found; i++) {
            assert_true(sent[index[i]] != tile[index[i]].samples);
            sent[index[i]] = tile[index[i]].samples;
        }
        rounds++;
    }
    for (size_t i = 0; i < MANY; i++) assert_int_equal(sent[i], tile[i].samples);
    assert_int_equal(rounds, (MANY - 1 + 6) / 7); /* one tile is empty */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(those_that_have_grown_most_come_first),
        cmocka_unit_test(no_more_than_asked_for),
        cmocka_unit_test(all_are_told_in_the_end),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
