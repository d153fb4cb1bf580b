/* Half floats. */
#include "math/half.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>

/* Half floats convert to themselves, and a float between two of them goes to the nearer one. */
static void rounding(void **state)
{
    (void)state;
    for (uint32_t h = 0; h < 0x7c00; h++) {
        const float x = rnd_half_decode((uint16_t)h), next = rnd_half_decode((uint16_t)(h + 1));
        assert_int_equal(rnd_half_encode(x), h);
        assert_int_equal(rnd_half_encode(-x), h | 0x8000);
        if (h == 0x7bff) break;
        assert_true(next > x);
        assert_int_equal(rnd_half_encode(x + 0.4375f * (next - x)), h);
        assert_int_equal(rnd_half_encode(x + 0.5625f * (next - x)), h + 1);
        assert_int_equal(rnd_half_encode(x + 0.5f * (next - x)), h % 2 ? h + 1 : h);
    }
    assert_true(rnd_half_decode(0x3c00) == 1 && rnd_half_decode(0x0001) == 0x1p-24f);
    assert_true(rnd_half_decode(rnd_half_encode(1e9f)) == 65504);
    assert_true(rnd_half_decode(rnd_half_encode(-INFINITY)) == -65504);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rounding)};
    return cmocka_run_group_tests_name("renderer_half", tests, NULL, NULL);
}
