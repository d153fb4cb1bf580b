/* The client against a daemon that keeps to the protocol: connecting, tiles and the picture they make,
 * acknowledgements, the clock. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <netinet/tcp.h>
#include <signal.h>
#include <sys/time.h>

#include "internal.h"
#include "protocol_server.h"

static struct pro_client *meet(struct server *server, void (*script)(struct server *), Fovea__Hello hello,
                               bool tcp)
{
    char error[PRO_ERROR_SIZE] = "";
    server->script = script;
    assert_true(server_start(server, tcp));
    struct pro_client *client = pro_connect(&server->address, &hello, PATIENCE_MS, false, error);
    if (!client) fail_msg("%s", error);
    return client;
}

static Fovea__Hello hello_for(Fovea__Encoding encoding)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    hello.client = "test 1";
    hello.tiles = encoding;
    return hello;
}

/* Receive until a message of this kind arrives, and return it. */
static Fovea__Message *receive(struct pro_client *client, Fovea__Message__BodyCase kind)
{
    for (;;) {
        char error[PRO_ERROR_SIZE] = "";
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, PATIENCE_MS, &message, error);
        if (result != PRO_MESSAGE) fail_msg("no message: %s", error);
        if (message->body_case == kind) return message;
        fovea__message__free_unpacked(message, NULL);
    }
}

/* Receive until Done, then whatever else has arrived, so that every tile so far is acknowledged. */
static void receive_done(struct pro_client *client)
{
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message = receive(client, FOVEA__MESSAGE__BODY_DONE);
    do fovea__message__free_unpacked(message, NULL);
    while (pro_receive(client, 0, &message, error) == PRO_MESSAGE);
}

static void send_done(struct server *server)
{
    Fovea__Done done = FOVEA__DONE__INIT;
    done.text = "line\nand \x1b[31mcolour \xc2\x9b[2J \x9b[2J \x7f\xc3\x9f";
    server_send(server, FOVEA__MESSAGE__BODY_DONE, &done);
}

/* --- tiles --- */

static void script_tiles(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    server_tile(server, 1, 1, 0, 3, 2, 0.5f);
    server_tile(server, 2, 1, 2, 0, 0, 0.25f);  /* coarse after fine */
    server_tile(server, 3, 0, 2, 1, 0, 0.125f); /* of a generation that has ended */
    send_done(server);
    server_until(server, FOVEA__MESSAGE__BODY_FREEZE);
    server_tile(server, 4, 2, 1, 1, 1, 0.75f); /* a new generation */
    send_done(server);
    server_until_gone(server);
}

static void tiles(bool tcp, Fovea__Encoding encoding, float tolerance)
{
    struct server server = {0};
    struct pro_client *client = meet(&server, script_tiles, hello_for(encoding), tcp);
    char error[PRO_ERROR_SIZE];
    static float rgb[WIDTH * HEIGHT * 3];
    assert_int_equal(pro_welcome(client)->width, WIDTH);
    assert_string_equal(pro_welcome(client)->server, "test");
    assert_true(pro_client_fd(client) >= 0);
    assert_true(pro_picture_coverage(pro_picture(client)) == 0);
    Fovea__Message *message = receive(client, FOVEA__MESSAGE__BODY_DONE);
    assert_string_equal(message->done->text, "line?and ?[31mcolour ??[2J ?[2J ?\xc3\x9f");
    fovea__message__free_unpacked(message, NULL);

    assert_true(pro_picture_coverage(pro_picture(client)) == 0.5);
    pro_picture_resolve(pro_picture(client), rgb);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            bool fine = x / TILE == 3 && y / TILE == 2;
            float expected = fine ? 0.5f : x < WIDTH / 2 ? 0.25f : 0;
            assert_float_equal(rgb[(y * WIDTH + x) * 3 + 1], expected, tolerance);
        }

    Fovea__Freeze freeze = FOVEA__FREEZE__INIT;
    Fovea__Message request = FOVEA__MESSAGE__INIT;
    request.body_case = FOVEA__MESSAGE__BODY_FREEZE;
    request.freeze = &freeze;
    assert_true(pro_send(client, &request, error));
    receive_done(client);
    pro_picture_resolve(pro_picture(client), rgb);
    assert_true(pro_picture_coverage(pro_picture(client)) == 4 / 32.0);
    assert_float_equal(rgb[(2 * TILE * WIDTH + 2 * TILE) * 3], 0.75f, tolerance);
    assert_true(rgb[0] == 0);
    pro_disconnect(client);
    server_finish(&server);
    assert_string_equal(server.client, "test 1");
    assert_int_equal(server.hello.version, PRO_VERSION);
    assert_int_equal(server.freezes, 1);
    assert_int_equal(server.acknowledged, 4);
    assert_false(server.went_back);
}

static int option(const struct pro_client *client, int level, int name)
{
    int value = -1;
    socklen_t size = sizeof value;
    assert_int_equal(getsockopt(pro_client_fd(client), level, name, &value, &size), 0);
    return value;
}

/* The kernel is set to notice that the daemon's machine has vanished. */
static void alive_on_tcp(void **state)
{
    (void)state;
    struct server server = {0};
    struct pro_client *client = meet(&server, script_tiles, hello_for(FOVEA__ENCODING__ENCODING_JPEG), true);
    assert_int_equal(option(client, SOL_SOCKET, SO_KEEPALIVE), 1);
    assert_int_equal(option(client, IPPROTO_TCP, TCP_KEEPIDLE) + option(client, IPPROTO_TCP, TCP_KEEPINTVL) *
                                                                     option(client, IPPROTO_TCP, TCP_KEEPCNT),
                     60);
    assert_int_equal(option(client, IPPROTO_TCP, TCP_USER_TIMEOUT), 60000);
    pro_disconnect(client);
    server_finish(&server);
}

static void tiles_unix(void **state)
{
    (void)state;
    tiles(false, FOVEA__ENCODING__ENCODING_HALF_ZSTD, 0);
}

static void tiles_tcp_jpeg(void **state)
{
    (void)state;
    tiles(true, FOVEA__ENCODING__ENCODING_JPEG, 0.01f);
}

/* --- acknowledgements --- */

enum { MANY = 300 };

/* Like a daemon, never have more tiles in flight than the window. */
static void script_window(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    for (uint64_t serial = 1; serial <= MANY; serial++) {
        while (serial - server->acknowledged > (unsigned)server->variant)
            if (!server_until(server, FOVEA__MESSAGE__BODY_ACKNOWLEDGE)) return;
        server_tile(server, serial, 1, 0, (uint32_t)serial % 8, 0, 1);
    }
    while (server->acknowledged < MANY)
        if (!server_until(server, FOVEA__MESSAGE__BODY_ACKNOWLEDGE)) return;
    send_done(server);
    server_until_gone(server);
}

static void window_never_stalls(void **state)
{
    (void)state;
    for (int window = 1; window <= 9; window++) {
        struct server server = {.variant = window};
        Fovea__Hello hello = hello_for(FOVEA__ENCODING__ENCODING_HALF_ZSTD);
        hello.window =
            window % 2 ? 0 : (uint32_t)window; /* 0: the daemon chooses, and does not tell the client */
        struct pro_client *client = meet(&server, script_window, hello, false);
        receive_done(client);
        pro_disconnect(client);
        server_finish(&server);
        assert_int_equal(server.acknowledged, MANY);
        assert_false(server.went_back);
    }
}

/* Send all tiles at once. The client begins to read only when all have arrived. */
static void script_burst(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    for (uint64_t serial = 1; serial <= 64; serial++) server_tile(server, serial, 1, 0, 0, 0, 1);
    send_done(server);
    while (server->acknowledged < 64)
        if (!server_until(server, FOVEA__MESSAGE__BODY_ACKNOWLEDGE)) return;
    server_until_gone(server);
}

static void burst_is_acknowledged_together(void **state)
{
    (void)state;
    struct server server = {0};
    struct pro_client *client =
        meet(&server, script_burst, hello_for(FOVEA__ENCODING__ENCODING_HALF_ZSTD), false);
    server_pause(200);
    receive_done(client);
    pro_disconnect(client);
    server_finish(&server);
    assert_int_equal(server.acknowledged, 64);
    assert_true(server.acknowledges >= 16 && server.acknowledges <= 32);
}

/* A daemon stops reading. What the client cannot send must not keep it from receiving, and must not make it
 * spin. */
static void script_deaf(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    server_until(server, FOVEA__MESSAGE__BODY_PING);
    for (uint64_t serial = 1; serial <= 5000; serial++) server_tile(server, serial, 1, 0, 0, 0, 1);
    send_done(server);
    server_pause(1500); /* until the next Ping is due */
    while (server->acknowledged < 5000)
        if (!server_until(server, FOVEA__MESSAGE__BODY_ACKNOWLEDGE)) return;
    send_done(server);
    server_until_gone(server);
}

/* How this thread calls ppoll(): the linker redirects the calls to the wrapper below. */
static _Thread_local unsigned polls;
static _Thread_local bool may_wait;
int __real_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t count, const struct timespec *timeout, const sigset_t *mask)
{
    polls++;
    may_wait |= !timeout || timeout->tv_sec != 0 || timeout->tv_nsec != 0;
    return __real_ppoll(fds, count, timeout, mask);
}

static void daemon_that_does_not_read(void **state)
{
    (void)state;
    struct server server = {0};
    struct pro_client *client =
        meet(&server, script_deaf, hello_for(FOVEA__ENCODING__ENCODING_HALF_ZSTD), false);
    receive_done(client);
    polls = 0;
    receive_done(client); /* the client sends what it held back as soon as the daemon reads again */
    assert_true(polls < 1000);
    pro_disconnect(client);
    server_finish(&server);
    assert_int_equal(server.acknowledged, 5000);
    assert_true(server.acknowledges < 5000 / 4);
}

/* --- time --- */

static void script_quiet(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    server_until_gone(server);
}

static void clock_and_pings(void **state)
{
    (void)state;
    struct server server = {0};
    struct pro_client *client = meet(&server, script_quiet, hello_for(FOVEA__ENCODING__ENCODING_NONE), false);
    uint64_t began = server_now_ns(), round_trip_ns;
    int64_t offset_ns;
    assert_false(pro_clock(client, &round_trip_ns, &offset_ns));
    for (int i = 0; i < 2; i++) {
        fovea__message__free_unpacked(receive(client, FOVEA__MESSAGE__BODY_PONG), NULL);
        assert_true(pro_clock(client, &round_trip_ns, &offset_ns));
        uint64_t error_ns = (uint64_t)llabs(offset_ns - 1000000000000);
        assert_true(error_ns <= round_trip_ns);
    }
    uint64_t took = server_now_ns() - began;
    assert_true(took >= 990000000);
    pro_disconnect(client);
    server_finish(&server);
    assert_in_range(server.pings, 2, 1 + (took + 10000000) / 1000000000); /* one a second */
}

static void estimate(void **state)
{
    (void)state;
    struct pro_estimate clock = {0};
    const uint64_t second = 1000000000;
    pro_estimate_add(&clock, 1000, 5000, 1200);
    assert_true(clock.known);
    assert_int_equal(clock.round_trip_ns, 200);
    assert_int_equal(clock.offset_ns, 3900);
    pro_estimate_add(&clock, 2000, 9000, 2500); /* a longer round trip tells less */
    assert_int_equal(clock.offset_ns, 3900);
    pro_estimate_add(&clock, 3000, 2000, 3100); /* a shorter one; the daemon's clock is behind ours */
    assert_int_equal(clock.round_trip_ns, 100);
    assert_int_equal(clock.offset_ns, -1050);
    const uint64_t ms = 1000000;
    pro_estimate_add(&clock, 10 * second, 0,
                     10 * second + 3 * ms); /* after 10 s, 2 ms more are allowed, 3 ms are not */
    assert_int_equal(clock.round_trip_ns, 100);
    pro_estimate_add(&clock, 10 * second, 0, 10 * second + 2 * ms);
    assert_int_equal(clock.round_trip_ns, 2 * ms);
    assert_true(clock.offset_ns == -(int64_t)(10 * second + ms));
}

static void on_alarm(int signal)
{
    (void)signal;
}

static void signals_do_not_shorten(void **state)
{
    (void)state;
    struct server server = {0};
    struct pro_client *client = meet(&server, script_quiet, hello_for(FOVEA__ENCODING__ENCODING_NONE), false);
    fovea__message__free_unpacked(receive(client, FOVEA__MESSAGE__BODY_PONG), NULL);
    struct sigaction action = {.sa_handler = on_alarm};
    struct itimerval often = {{0, 5000}, {0, 5000}}, never = {{0, 0}, {0, 0}};
    sigaction(SIGALRM, &action, NULL);
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message;
    setitimer(ITIMER_REAL, &often, NULL);
    uint64_t began = server_now_ns();
    /* On a slow machine the next Pong may arrive first. */
    while (pro_receive(client, 150, &message, error) == PRO_MESSAGE) {
        fovea__message__free_unpacked(message, NULL);
        began = server_now_ns();
    }
    uint64_t took = server_now_ns() - began;
    setitimer(ITIMER_REAL, &never, NULL);
    assert_true(took >= 150000000);
    may_wait = false;
    if (pro_receive(client, 0, &message, error) == PRO_MESSAGE) fovea__message__free_unpacked(message, NULL);
    assert_false(may_wait);
    pro_disconnect(client);
    server_finish(&server);
}

/* --- connecting --- */

static void waits_for_a_late_daemon(void **state)
{
    (void)state;
    for (int tcp = 0; tcp <= 1; tcp++) {
        struct server server = {.script = script_quiet, .is_late = true};
        Fovea__Hello hello = hello_for(FOVEA__ENCODING__ENCODING_NONE);
        char error[PRO_ERROR_SIZE] = "";
        assert_true(server_start(&server, tcp));
        assert_null(pro_connect(&server.address, &hello, PATIENCE_MS, false, error));
        assert_non_null(strstr(error, "nothing listens at"));
        atomic_store(&server.may_listen, true);
        struct pro_client *client = pro_connect(&server.address, &hello, PATIENCE_MS, true, error);
        assert_non_null(client);
        pro_disconnect(client);
        server_finish(&server);
    }
}

static void nothing_listens(void **state)
{
    (void)state;
    Fovea__Hello hello = hello_for(FOVEA__ENCODING__ENCODING_NONE);
    char error[PRO_ERROR_SIZE] = "";
    struct pro_address address = {.is_unix = true, .path = "/tmp/fovea-test-nothing-here/socket"};
    assert_null(pro_connect(&address, &hello, 5000, false, error));
    assert_string_equal(
        error, "nothing listens at unix:/tmp/fovea-test-nothing-here/socket: No such file or directory");
    uint64_t began = server_now_ns();
    assert_null(pro_connect(&address, &hello, 100, true, error));
    uint64_t took = server_now_ns() - began;
    assert_true(took >= 100000000);
    struct pro_address nowhere = {.host = "no such host.invalid", .port = 1};
    assert_null(pro_connect(&nowhere, &hello, 5000, false, error));
    assert_non_null(strstr(error, "tcp:no such host.invalid:1: "));
    pro_disconnect(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_unix),
        cmocka_unit_test(tiles_tcp_jpeg),
        cmocka_unit_test(alive_on_tcp),
        cmocka_unit_test(window_never_stalls),
        cmocka_unit_test(burst_is_acknowledged_together),
        cmocka_unit_test(daemon_that_does_not_read),
        cmocka_unit_test(clock_and_pings),
        cmocka_unit_test(estimate),
        cmocka_unit_test(signals_do_not_shorten),
        cmocka_unit_test(waits_for_a_late_daemon),
        cmocka_unit_test(nothing_listens),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
