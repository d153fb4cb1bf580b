/* Packets for tev and HDRView, byte for byte. Most of them were written by hand from the layouts in tev's
 * include/tev/Ipc.h and include/tev/VectorGraphics.h. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "protocol.h"

/* Takes and frees the packet. golden: bytes as two hex digits, with any blanks between them. */
static void expect(const char *golden, uint8_t *packet, size_t count)
{
    size_t at = 0;
    assert_non_null(packet);
    for (const char *c = golden; *c; c++) {
        char digits[3] = {c[0], c[1]};
        if (*c == ' ') continue;
        assert_true(at < count);
        if (packet[at] != strtoul(digits, NULL, 16))
            fail_msg("byte %zu is %02x, expected %s", at, packet[at], digits);
        at++;
        c++;
    }
    assert_int_equal(at, count);
    free(packet);
}

static void create(void **state)
{
    const struct pro_tev_image image = {"f", 4, 2, 3, (const char *const[]){"R", "G", "B"}};
    size_t count;
    (void)state;
    uint8_t *packet = pro_tev_create(&image, &count);
    expect("1a000000 04 01 6600 04000000 02000000 03000000 5200 4700 4200", packet, count);
}

static void create_with_names_of_any_length(void **state)
{
    const struct pro_tev_image image = {"fovead a\xc3\xa4", 32768, 16384, 2,
                                        (const char *const[]){"samples", "albedo.R"}};
    size_t count;
    (void)state;
    uint8_t *packet = pro_tev_create(&image, &count);
    expect("2e000000 04 01 666f766561642061c3a400 00800000 00400000 02000000 73616d706c657300 "
           "616c6265646f2e5200",
           packet, count);
}

/* Two pixels below each other at (3, 1), with channels A = 1, 2 and B = -0.5, 0.25. */
static void update(void **state)
{
    const struct pro_tev_image image = {"f", 4, 3, 2, (const char *const[]){"A", "B"}};
    const struct pro_tev_part part = {3, 1, 1, 2, (const float[]){1.0f, -0.5f, 2.0f, 0.25f}};
    size_t count;
    (void)state;
    uint8_t *packet = pro_tev_update(&image, &part, &count);
    expect("50000000 06 00 6600 02000000 4100 4200 03000000 01000000 01000000 02000000 "
           "0000000000000000 0100000000000000 0200000000000000 0200000000000000 "
           "0000803f 000000bf 00000040 0000803e",
           packet, count);
}

static void draw(void **state)
{
    const struct pro_tev_image image = {.name = "f"};
    const struct pro_tev_command command[] = {
        {PRO_TEV_BEGIN, {0}},         {PRO_TEV_COLOUR, {1.0f, 0.5f, 0.0f, 1.0f}},
        {PRO_TEV_MOVE_TO, {1.5f, 2}}, {PRO_TEV_LINE_TO, {4096, -1}},
        {PRO_TEV_STROKE, {0}},
    };
    size_t count;
    (void)state;
    uint8_t *packet = pro_tev_draw(&image, command, 5, &count);
    expect("32000000 08 00 6600 00 05000000 06 04 0000803f 0000003f 00000000 0000803f "
           "0a 0000c03f 00000040 0b 00008045 000080bf 05",
           packet, count);
}

static void draw_nothing(void **state)
{
    const struct pro_tev_image image = {.name = ""};
    size_t count;
    (void)state;
    uint8_t *packet = pro_tev_draw(&image, NULL, 0, &count);
    expect("0c000000 08 00 00 00 00000000", packet, count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(create),       cmocka_unit_test(create_with_names_of_any_length),
        cmocka_unit_test(update),       cmocka_unit_test(draw),
        cmocka_unit_test(draw_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
