/* Addresses: text to address and back, defaults, and what is refused with which line. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "protocol.h"

static void assert_address(const char *text, bool is_unix, const char *where, int port, bool local,
                           const char *again)
{
    struct pro_address address;
    char error[PRO_ERROR_SIZE], printed[300];
    assert_true(pro_address_parse(text, &address, error));
    assert_int_equal(address.is_unix, is_unix);
    assert_string_equal(is_unix ? address.path : address.host, where);
    assert_int_equal(address.port, port);
    assert_int_equal(pro_address_is_local(&address), local);
    pro_address_print(&address, printed, sizeof printed);
    assert_string_equal(printed, again);
    assert_true(pro_address_parse(printed, &address, error));
    assert_string_equal(is_unix ? address.path : address.host, where);
}

static void good(void **state)
{
    (void)state;
    assert_address("unix:/run/x.sock", true, "/run/x.sock", 0, true, "unix:/run/x.sock");
    assert_address("unix:here", true, "here", 0, true, "unix:here");
    assert_address("/run/x.sock", true, "/run/x.sock", 0, true, "unix:/run/x.sock");
    assert_address("./x", true, "./x", 0, true, "unix:./x");
    assert_address("tcp:localhost:7000", false, "localhost", 7000, true, "tcp:localhost:7000");
    assert_address("tcp:127.0.0.1:1", false, "127.0.0.1", 1, true, "tcp:127.0.0.1:1");
    assert_address("tcp:127.9.8.7:65535", false, "127.9.8.7", 65535, true, "tcp:127.9.8.7:65535");
    assert_address("tcp:[::1]:7000", false, "::1", 7000, true, "tcp:[::1]:7000");
    assert_address("tcp:[fe80::1%eth0]:7000", false, "fe80::1%eth0", 7000, false, "tcp:[fe80::1%eth0]:7000");
    assert_address("tcp:0.0.0.0:7000", false, "0.0.0.0", 7000, false, "tcp:0.0.0.0:7000");
    assert_address("tcp:128.0.0.1:7000", false, "128.0.0.1", 7000, false, "tcp:128.0.0.1:7000");
    assert_address("tcp:[::]:7000", false, "::", 7000, false, "tcp:[::]:7000");
    assert_address("tcp:localhost.example.org:80", false, "localhost.example.org", 80, false,
                   "tcp:localhost.example.org:80");
}

static void assert_refused(const char *text, const char *part)
{
    struct pro_address address;
    char error[PRO_ERROR_SIZE] = "";
    assert_false(pro_address_parse(text, &address, error));
    if (!strstr(error, part)) fail_msg("'%s' does not say '%s'", error, part);
    assert_null(strchr(error, '\n'));
}

static void assert_default(const char *folder)
{
    struct pro_address address;
    char error[PRO_ERROR_SIZE] = "", expected[200];
    if (!pro_address_parse(NULL, &address, error)) fail_msg("%s", error);
    snprintf(expected, sizeof expected, "%s/fovead.sock", folder);
    assert_true(address.is_unix);
    assert_string_equal(address.path, expected);
}

/* By default the socket is where nobody else can put one: in a folder that belongs to this user and is no
 * link. */
static void defaults(void **state)
{
    (void)state;
    char folder[] = "/tmp/fovead-test-XXXXXX", other[64], link[64], slashed[80];
    assert_non_null(mkdtemp(folder));
    snprintf(other, sizeof other, "%s/other", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    assert_int_equal(mkdir(other, 0700), 0);
    assert_int_equal(symlink(other, link), 0);

    setenv("XDG_RUNTIME_DIR", other, 1);
    assert_default(other);
    snprintf(slashed, sizeof slashed, "%s//", other);
    setenv("XDG_RUNTIME_DIR", slashed, 1);
    assert_default(other);
    assert_int_equal(chmod(other, 0755), 0);
    assert_default(other);
    const mode_t modes[] = {0770, 0720, 0702, 0777, 01777};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        assert_int_equal(chmod(other, modes[i]), 0);
        assert_refused(NULL, "that nobody else can write to");
    }
    assert_int_equal(chmod(other, 0700), 0);
    setenv("XDG_RUNTIME_DIR", link, 1);
    assert_refused(NULL, "that nobody else can write to");
    snprintf(slashed, sizeof slashed, "%s/", link);
    setenv("XDG_RUNTIME_DIR", slashed, 1);
    assert_refused(NULL, "that nobody else can write to");
    if (geteuid() == 0) {
        setenv("XDG_RUNTIME_DIR", other, 1);
        assert_int_equal(chown(other, 65534, (gid_t)-1), 0);
        assert_refused(NULL, "expected a folder of user 0");
    } else {
        printf("not root: another user's folder is left out\n");
    }
    unlink(link);
    rmdir(other);
    assert_refused(NULL, "No such file");
    rmdir(folder);
}

/* Without such a folder, the default is a folder of the project's own in /tmp. */
static void default_without_runtime_folder(void **state)
{
    (void)state;
    char folder[64];
    struct stat status;
    snprintf(folder, sizeof folder, "/tmp/fovead-%u", (unsigned)geteuid());
    if (lstat(folder, &status) == 0 && (status.st_uid != geteuid() || status.st_mode & 022)) {
        printf("%s is not as fovead makes it: left out\n", folder);
        skip();
    }
    const char *none[] = {NULL, "", "run/user/5"};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        if (none[i])
            setenv("XDG_RUNTIME_DIR", none[i], 1);
        else
            unsetenv("XDG_RUNTIME_DIR");
        assert_default(folder);
    }
    assert_int_equal(lstat(folder, &status), 0);
    assert_true(S_ISDIR(status.st_mode));
    assert_int_equal(status.st_uid, geteuid());
    assert_int_equal(status.st_mode & 022, 0);
}

static void bad(void **state)
{
    (void)state;
    char path[400] = "unix:/";
    memset(path + 6, 'p', 106);
    struct pro_address address;
    char error[PRO_ERROR_SIZE];
    assert_true(pro_address_parse(path, &address, error));
    assert_int_equal(strlen(address.path), 107);
    path[112] = 'p';
    assert_refused(path, "108 bytes, where a socket's path may have 107");
    memset(path + 6, 'p', sizeof path - 7);
    assert_refused(path + 5, "bytes, where a socket's path may have 107");
    setenv("XDG_RUNTIME_DIR", path + 5, 1);
    assert_refused(NULL, "bytes, where a socket's path may have 107");
    unsetenv("XDG_RUNTIME_DIR");

    assert_refused("", "'' is no address");
    assert_refused("fovead", "'fovead' is no address");
    assert_refused("localhost:7000", "expected unix:PATH, tcp:HOST:PORT");
    assert_refused("two\nlines\x1b[2J", "'two?lines?[2J' is no address");
    assert_refused("unix:", "no path");
    assert_refused("tcp:", "no port");
    assert_refused("tcp:host", "no port");
    assert_refused("tcp::7000", "no host");
    assert_refused("tcp:[]:7000", "no host");
    assert_refused("tcp:::1:7000", "brackets");
    assert_refused("tcp:[::1]", "[IPv6]:PORT");
    assert_refused("tcp:[::1:7000", "[IPv6]:PORT");
    const char *ports[] = {"",    "0",   "65536", "99999",      "100000", "-1",
                           "+80", " 80", "80x",   "4294967376", "http"};
    for (size_t i = 0; i < sizeof ports / sizeof *ports; i++) {
        char text[64];
        snprintf(text, sizeof text, "tcp:host:%s", ports[i]);
        assert_refused(text, "the port is a number from 1 to 65535");
    }
    char host[400] = "tcp:";
    memset(host + 4, 'h', 300);
    strcpy(host + 304, ":80");
    assert_refused(host, "too long a host");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(good), cmocka_unit_test(defaults),
                                       cmocka_unit_test(default_without_runtime_folder),
                                       cmocka_unit_test(bad)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
