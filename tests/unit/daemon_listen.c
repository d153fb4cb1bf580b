/* Listening: when several daemons start at once, one of them gets the socket; clients of other users are
 * refused; and listening on TCP has conditions. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "listen.h"

enum { DAEMONS = 6, ROUNDS = 50, SOMEBODY_ELSE = 65534 };

static char folder[64];
static struct pro_address address;

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/fovead-test-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    address = (struct pro_address){.is_unix = true};
    snprintf(address.path, sizeof(address.path), "%s/socket", folder);
    return 0;
}

static int remove_folder(void **state)
{
    char name[128];

    (void)state;
    snprintf(name, sizeof(name), "%s.lock", address.path);
    unlink(name);
    unlink(address.path);
    return rmdir(folder);
}

static bool is_there(const char *suffix)
{
    char name[128];

    snprintf(name, sizeof(name), "%s%s", address.path, suffix);
    return !access(name, F_OK);
}

static int dial(void)
{
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    memcpy(name.sun_path, address.path, sizeof(name.sun_path));
    if (fd >= 0 && !connect(fd, (struct sockaddr *)&name, sizeof(name))) return fd;
    close(fd);
    return -1;
}

/* Leave the socket of a daemon that was killed: nobody listens on it, and nobody holds its lock file. */
static void leave_stale(void)
{
    struct dmn_listener listener;
    char error[PRO_ERROR_SIZE];
    pid_t child = fork();
    int status;

    assert_true(child >= 0);
    if (child == 0) _exit(dmn_listener_init(&listener, &address, NULL, error) ? 0 : 1);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_true(is_there(""));
    assert_int_equal(dial(), -1);
}

/* One of many daemons: it starts when `go` is closed, reports its success to `said`, and stays until `stay`
 * is closed. */
static void run_daemon(int go, int stay, int said)
{
    struct dmn_listener listener;
    char error[PRO_ERROR_SIZE] = "", byte;
    bool good;

    if (read(go, &byte, 1) != 0) _exit(1);
    good = dmn_listener_init(&listener, &address, NULL, error);
    byte = good ? 'w' : strstr(error, "in use by a running daemon") ? 'u' : '?';
    if (byte == '?') fprintf(stderr, "%s\n", error);
    if (write(said, &byte, 1) != 1 || read(stay, &byte, 1) != 0) _exit(1);
    if (good) dmn_listener_finish(&listener);
    _exit(0);
}

/* Several daemons start at once where a dead one left its socket: one of them gets the socket, and clients
 * reach it. */
static void one_wins(void **state)
{
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        int go[2], stay[2], said[2], winners = 0, fd;
        char byte;

        leave_stale();
        assert_true(!pipe(go) && !pipe(stay) && !pipe(said));
        for (int i = 0; i < DAEMONS; i++) {
            pid_t child = fork();

            assert_true(child >= 0);
            if (child > 0) continue;
            close(go[1]);
            close(stay[1]);
            run_daemon(go[0], stay[0], said[1]);
        }
        close(go[1]);
        for (int i = 0; i < DAEMONS; i++) {
            assert_int_equal(read(said[0], &byte, 1), 1);
            assert_int_not_equal(byte, '?');
            winners += byte == 'w';
        }
        assert_int_equal(winners, 1);
        fd = dial();
        assert_true(fd >= 0);
        close(fd);
        close(stay[1]);
        for (int i = 0; i < DAEMONS; i++) assert_true(wait(NULL) > 0);
        for (int i = 0; i < 2; i++) close(said[i]);
        close(go[0]);
        close(stay[0]);
        assert_false(is_there("") || is_there(".lock"));
    }
}

static void modes(void **state)
{
    struct dmn_listener listener;
    char error[PRO_ERROR_SIZE];
    struct stat status;
    mode_t before = umask(0);

    (void)state;
    assert_true(dmn_listener_init(&listener, &address, "sesame", error));
    umask(before);
    assert_int_equal(lstat(address.path, &status), 0);
    assert_int_equal(status.st_mode & 07777, 0600);
    assert_int_equal(fstat(listener.lock, &status), 0);
    assert_int_equal(status.st_mode & 07777, 0600);
    assert_null(listener.token); /* whoever can open the socket has this user's rights anyway */
    dmn_listener_finish(&listener);
    assert_false(is_there("") || is_there(".lock"));
}

static void squatted_lock(void **state)
{
    struct dmn_listener listener;
    char error[PRO_ERROR_SIZE] = "", name[128];

    (void)state;
    snprintf(name, sizeof(name), "%s.lock", address.path);
    assert_int_equal(symlink("/etc/passwd", name), 0);
    assert_false(dmn_listener_init(&listener, &address, NULL, error));
    assert_non_null(strstr(error, ".lock"));
    assert_true(is_there(".lock") && !is_there(""));
    assert_int_equal(unlink(name), 0);
    assert_int_equal(mkfifo(name, 0600), 0);
    assert_false(dmn_listener_init(&listener, &address, NULL, error));
    assert_non_null(strstr(error, ".lock: expected a file of this user"));
    assert_int_equal(unlink(name), 0);
}

/* Even after somebody has changed the mode of the socket, only this user may connect, because the daemon
 * writes files for its clients. */
static void strangers(void **state)
{
    struct dmn_listener listener;
    char error[PRO_ERROR_SIZE], byte;
    struct dmn_peer peer;
    pid_t child;
    int fd, alive[2];

    (void)state;
    if (geteuid() != 0) {
        printf("not root: another user's client is left out\n");
        skip();
    }
    assert_true(dmn_listener_init(&listener, &address, NULL, error));
    assert_true(!chmod(folder, 0755) && !chmod(address.path, 0666));
    assert_int_equal(pipe(alive), 0);
    child = fork();
    if (child == 0) {
        if (setuid(SOMEBODY_ELSE) || (fd = dial()) < 0) _exit(1);
        _exit(read(fd, &byte, 1) == 0 ? 0 : 2); /* the daemon closed the connection without a word */
    }
    close(alive[1]);
    /* until a client connects, or the child has ended */
    struct pollfd wait[] = {{.fd = listener.fd, .events = POLLIN}, {.fd = alive[0]}};
    while (poll(wait, 2, -1) < 1) continue;
    assert_true(wait[0].revents & POLLIN);
    close(alive[0]);
    fd = dmn_listener_accept(&listener, &peer);
    assert_true(fd >= 0);
    assert_int_equal(peer.user, SOMEBODY_ELSE);
    assert_false(dmn_peer_is_own(&peer));
    close(fd);
    assert_true(waitpid(child, &fd, 0) == child);
    assert_int_equal(fd, 0);
    /* A client of this user may connect. */
    fd = dial();
    assert_true(fd >= 0);
    close(dmn_listener_accept(&listener, &peer));
    assert_true(dmn_peer_is_own(&peer));
    assert_non_null(strstr(peer.name, "process "));
    close(fd);
    dmn_listener_finish(&listener);
}

static int option(int fd, int level, int name)
{
    socklen_t size = sizeof(int);
    int value = -1;

    assert_int_equal(getsockopt(fd, level, name, &value, &size), 0);
    return value;
}

/* Clients on loopback also need the token, and the kernel is set to notice a peer that vanishes. */
static void tcp(void **state)
{
    struct dmn_listener listener;
    struct sockaddr_in name = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof(name);
    struct pro_address local = {.host = "127.0.0.1"};
    int probe = socket(AF_INET, SOCK_STREAM, 0), fd, client;
    char error[PRO_ERROR_SIZE] = "";
    struct dmn_peer peer;

    (void)state;
    assert_true(!bind(probe, (struct sockaddr *)&name, size) &&
                !getsockname(probe, (struct sockaddr *)&name, &size));
    close(probe);
    local.port = ntohs(name.sin_port);
    if (!dmn_listener_init(&listener, &local, "sesame", error)) fail_msg("%s", error);
    assert_string_equal(listener.token, "sesame");
    client = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(connect(client, (struct sockaddr *)&name, size), 0);
    while (poll(&(struct pollfd){.fd = listener.fd, .events = POLLIN}, 1, -1) != 1) continue;
    fd = dmn_listener_accept(&listener, &peer);
    assert_true(fd >= 0);
    assert_int_equal(option(fd, SOL_SOCKET, SO_KEEPALIVE), 1);
    assert_int_equal(option(fd, IPPROTO_TCP, TCP_KEEPIDLE) +
                         option(fd, IPPROTO_TCP, TCP_KEEPINTVL) * option(fd, IPPROTO_TCP, TCP_KEEPCNT),
                     60);
    assert_int_equal(option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT), 60000);
    assert_int_equal(peer.key, INADDR_LOOPBACK);
    assert_non_null(strstr(peer.name, "127.0.0.1 port "));
    assert_false(peer.is_local || dmn_peer_is_own(&peer));
    close(fd);
    close(client);
    dmn_listener_finish(&listener);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(one_wins), cmocka_unit_test(modes),
                                       cmocka_unit_test(squatted_lock), cmocka_unit_test(strangers),
                                       cmocka_unit_test(tcp)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
