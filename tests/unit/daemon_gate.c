/* The gate: guesses of a token are checked one per second, wherever they come from, and a right token does
 * not wait longer than that. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <string.h>

#include "gate.h"

static const uint64_t SECOND = 1000000000, START = 5000000000000;

static uint64_t key_of(const char *text)
{
    struct sockaddr_storage address = {.ss_family = strchr(text, ':') ? AF_INET6 : AF_INET};
    struct sockaddr_in *v4 = (struct sockaddr_in *)&address;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)&address;
    void *bytes = address.ss_family == AF_INET ? (void *)&v4->sin_addr : (void *)&v6->sin6_addr;

    assert_int_equal(inet_pton(address.ss_family, text, bytes), 1);
    return dmn_gate_key(&address);
}

static void tokens(void **state)
{
    (void)state;
    assert_true(dmn_gate_knows("sesame", "sesame"));
    assert_false(dmn_gate_knows("sesame", ""));
    assert_false(dmn_gate_knows("sesame", "sesam"));
    assert_false(dmn_gate_knows("sesame", "sesamen"));
    assert_false(dmn_gate_knows("sesame", "Sesame"));
    assert_false(dmn_gate_knows("sesame", "sesamE"));
    assert_false(dmn_gate_knows("\x80", "\x01"));
}

static void addresses(void **state)
{
    (void)state;
    assert_int_equal(key_of("127.0.0.1"), key_of("127.200.3.4"));
    assert_int_equal(key_of("127.0.0.1"), key_of("::1"));
    assert_int_equal(key_of("127.0.0.1"), key_of("::ffff:127.0.0.1"));
    assert_int_equal(key_of("192.0.2.7"), key_of("::ffff:192.0.2.7"));
    assert_int_equal(key_of("2001:db8:1:2::1"), key_of("2001:db8:1:2:ffff::9"));
    assert_int_not_equal(key_of("2001:db8:1:2::1"), key_of("2001:db8:1:3::1"));
    assert_int_not_equal(key_of("192.0.2.7"), key_of("192.0.2.8"));
    assert_int_not_equal(key_of("192.0.2.7"), key_of("127.0.0.1"));
}

static void one_a_second(void **state)
{
    struct dmn_gate gate = {0};

    (void)state;
    /* Who is right, or has said nothing wrong, never waits. */
    for (int i = 0; i < 100; i++) assert_int_equal(dmn_gate_turn(&gate, 1, START), START);
    dmn_gate_wrong(&gate, 1, START);
    /* The others get turns, a fixed number of them, whether they stay for their answers or not. */
    for (uint64_t i = 1; i <= DMN_GATE_QUEUE; i++)
        assert_int_equal(dmn_gate_turn(&gate, 1, START + 5), START + i * SECOND);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + 5), 0);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + SECOND + 5), START + (DMN_GATE_QUEUE + 1) * SECOND);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + SECOND + 5), 0);
    /* Somebody else does not wait for them. */
    assert_int_equal(dmn_gate_turn(&gate, 2, START + 5), START + 5);
    /* When they are through, it is open again. */
    assert_int_equal(dmn_gate_turn(&gate, 1, START + 100 * SECOND), START + 100 * SECOND);
}

/* After a wrong token a right one waits once; right ones after it do not wait one after another. */
static void right_after_wrong(void **state)
{
    struct dmn_gate gate = {0};

    (void)state;
    dmn_gate_wrong(&gate, 1, START);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + 1), START + SECOND);
    dmn_gate_right(&gate, 1);
    for (uint64_t i = 1; i < 100; i++)
        assert_int_equal(dmn_gate_turn(&gate, 1, START + SECOND + i), START + SECOND + i);
}

/* Tokens that are looked at for somebody with so many addresses, who has a thousand tries a second for so
 * long. */
static unsigned guesses(uint64_t addresses_of, uint64_t seconds)
{
    struct dmn_gate gate = {0};
    unsigned looked_at = 0;

    for (uint64_t i = 0; i < seconds * 1000; i++) {
        uint64_t now_ns = START + i * SECOND / 1000, key = 7 + i % addresses_of;
        uint64_t turn_ns = dmn_gate_turn(&gate, key, now_ns);

        looked_at += turn_ns && turn_ns < START + seconds * SECOND;
        if (turn_ns == now_ns) dmn_gate_wrong(&gate, key, now_ns);
    }
    return looked_at;
}

static void many_addresses(void **state)
{
    (void)state;
    assert_in_range(guesses(1, 50), 49, 51);
    assert_in_range(guesses(DMN_GATE_PLACES, 50), 49 * DMN_GATE_PLACES, 51 * DMN_GATE_PLACES);
    assert_in_range(guesses(1000, 50), 1, 51 * DMN_GATE_PLACES);
    assert_in_range(guesses(50000, 50), 1, 51 * DMN_GATE_PLACES);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(tokens), cmocka_unit_test(addresses),
                                       cmocka_unit_test(one_a_second), cmocka_unit_test(right_after_wrong),
                                       cmocka_unit_test(many_addresses)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
