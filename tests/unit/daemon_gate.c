/* The gate: one guess of a token is checked per second, whatever address it comes from, and a right token
 * waits no longer than that. */
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
    /* A client waits only after a wrong token. */
    for (int i = 0; i < 100; i++) assert_int_equal(dmn_gate_turn(&gate, 1, START), START);
    dmn_gate_wrong(&gate, 1, START);
    /* Later clients get turns, a limited number of them, whether or not they stay for their answers. */
    for (uint64_t i = 1; i <= DMN_GATE_QUEUE; i++)
        assert_int_equal(dmn_gate_turn(&gate, 1, START + 5), START + i * SECOND);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + 5), 0);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + SECOND + 5), START + (DMN_GATE_QUEUE + 1) * SECOND);
    assert_int_equal(dmn_gate_turn(&gate, 1, START + SECOND + 5), 0);
    /* Clients from other addresses do not wait for them. */
    assert_int_equal(dmn_gate_turn(&gate, 2, START + 5), START + 5);
    /* When all turns are over, nobody waits any more. */
    assert_int_equal(dmn_gate_turn(&gate, 1, START + 100 * SECOND), START + 100 * SECOND);
}

/* After a wrong token, the next right one waits once; the right ones after it do not wait one after another.
 */
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

/* How many tokens are checked for an attacker with this many addresses, who tries a thousand tokens per
 * second for this long. */
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
