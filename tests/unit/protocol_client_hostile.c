/* The client against daemons that break the protocol: each connection ends with one line that says how the
 * daemon broke it, and nothing worse happens. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "protocol_server.h"

/* Connect, and receive until the connection breaks. The error must contain `part`. */
static void assert_breaks(void (*script)(struct server *), int variant, const char *part)
{
    struct server server = {.script = script, .variant = variant};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE] = "";
    hello.tiles = FOVEA__ENCODING__ENCODING_HALF_ZSTD;
    assert_true(server_start(&server, variant % 2));
    struct pro_client *client = pro_connect(&server.address, &hello, PATIENCE_MS, false, error);
    if (client) {
        Fovea__Message *message;
        enum pro_result result;
        while ((result = pro_receive(client, PATIENCE_MS, &message, error)) == PRO_MESSAGE)
            fovea__message__free_unpacked(message, NULL);
        assert_int_equal(result, PRO_BROKEN);
        assert_null(message);
    }
    pro_disconnect(client);
    server_finish(&server);
    if (!strstr(error, part)) fail_msg("variant %d: '%s' does not say '%s'", variant, error, part);
    for (const char *c = error; *c; c++) assert_true((unsigned char)*c >= 0x20);
}

/* --- another user --- */

enum { SOMEBODY_ELSE = 65534 };

/* Listen as another user on a socket in the daemon's place. Exits with 0 if the client sent nothing. */
static void squat(const struct sockaddr_un *at, int ready)
{
    int listener = socket(AF_UNIX, SOCK_STREAM, 0), fd;
    char byte;
    if (setuid(SOMEBODY_ELSE) != 0 || bind(listener, (const struct sockaddr *)at, sizeof *at) != 0 ||
        listen(listener, 4) != 0 || write(ready, "", 1) != 1 || (fd = accept(listener, NULL, NULL)) < 0)
        _exit(1);
    _exit(recv(fd, &byte, 1, 0) == 0 ? 0 : 2);
}

static void stranger_hears_nothing(void **state)
{
    (void)state;
    struct pro_address address = {.is_unix = true};
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char folder[] = "/tmp/fovea-test-XXXXXX", error[PRO_ERROR_SIZE] = "", byte;
    int ready[2], status;
    if (geteuid() != 0) {
        printf("not root: a socket of another user is left out\n");
        skip();
    }
    hello.token = "sesame";
    assert_non_null(mkdtemp(folder));
    assert_int_equal(chmod(folder, 01777), 0);
    snprintf(at.sun_path, sizeof at.sun_path, "%s/socket", folder);
    strcpy(address.path, at.sun_path);
    assert_int_equal(pipe(ready), 0);
    pid_t child = fork();
    if (child == 0) squat(&at, ready[1]);
    close(ready[1]); /* if the child fails, its end of the pipe closes and read() returns */
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_null(pro_connect(&address, &hello, PATIENCE_MS, false, error));
    if (!strstr(error, "user 65534 listens at unix:/tmp/") || !strstr(error, "nothing was sent"))
        fail_msg("%s", error);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    unlink(at.sun_path);
    rmdir(folder);
    close(ready[0]);
}

/* --- before Welcome --- */

static void script_silent(struct server *server)
{
    server_until_gone(server);
}

static void never_answers(void **state)
{
    (void)state;
    struct server server = {.script = script_silent};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE] = "";
    assert_true(server_start(&server, false));
    uint64_t began = server_now_ns();
    assert_null(pro_connect(&server.address, &hello, 100, false, error));
    uint64_t took = server_now_ns() - began;
    assert_true(took >= 100000000);
    assert_non_null(strstr(error, "has not answered within 0.1 s"));
    server_finish(&server);
}

static void script_welcome(struct server *server)
{
    Fovea__Welcome welcome = server_film();
    switch (server->variant) {
    case 0:
        welcome.version = 2;
        break;
    case 1:
        welcome.width = UINT32_MAX;
        break;
    case 2:
        welcome.height = 0;
        break;
    case 3:
        welcome.width = welcome.height = 65536;
        break;
    case 4:
        welcome.tile_size = 0;
        break;
    case 5:
        welcome.tile_size = 100000;
        break;
    case 6:
        welcome.tile_size = 48;
        break;
    case 7:
        welcome.levels = 0;
        break;
    case 8:
        welcome.levels = 33;
        break;
    case 9:
        welcome.width = 32768, welcome.height = 16384, welcome.tile_size = 1;
        break;
    }
    server_send(server, FOVEA__MESSAGE__BODY_WELCOME, &welcome);
    server_until_gone(server);
}

static void absurd_welcome(void **state)
{
    (void)state;
    static const char *const parts[] = {
        "speaks version 2", "film has 4294967295 x", "x 0 pixels", "65536 x 65536", "tiles of 0 pixels",
        "tiles of 100000",  "tiles of 48",           "0 levels",   "33 levels",     "too many",
    };
    for (int i = 0; i < 10; i++) assert_breaks(script_welcome, i, parts[i]);
}

static void script_first_word(struct server *server)
{
    Fovea__Done done = FOVEA__DONE__INIT;
    Fovea__Stats stats = FOVEA__STATS__INIT;
    done.text = "wrong token\r\n\x1b[2J";
    server->hello.tiles = FOVEA__ENCODING__ENCODING_HALF_ZSTD;
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    switch (server->variant) {
    case 0:
        server_send(server, FOVEA__MESSAGE__BODY_DONE, &done);
        break;
    case 1:
        server_tile(server, 1, 1, 0, 0, 0, 1);
        break;
    case 2:
        server_send(server, FOVEA__MESSAGE__BODY_STATS, &stats);
        break;
    case 3:
        server_write(server, "HTTP/1.1 400 Bad Request\r\n\r\n", 28);
        break;
    case 4:
        server_write(server, "\0\0\0\0", 4);
        break;
    case 5:
        server_write(server, "\0\x80\0\1", 4);
        break;
    case 6:
        server_write(server, "\0\0\0\3abc", 7);
        break;
    case 7:
        break;
    }
    shutdown(server->fd, SHUT_WR);
    server_until_gone(server);
}

static void wrong_first_word(void **state)
{
    (void)state;
    static const char *const parts[] = {
        "refused: wrong token??",
        "out of place",
        "out of place",
        "a message of 1213486160 bytes",
        "of length zero",
        "a message of 8388609 bytes, where 8388608 is the limit",
        "3 bytes that are not a message",
        "has closed the connection",
    };
    for (int i = 0; i < 8; i++) assert_breaks(script_first_word, i, parts[i]);
}

/* --- after Welcome --- */

static void script_bad_tile(struct server *server)
{
    Fovea__Tile tile = FOVEA__TILE__INIT;
    static const float rgb[TILE * TILE * 3];
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    tile.serial = 1;
    tile.generation = 1;
    tile.encoding = server->hello.tiles;
    tile.data.data = pro_encode(tile.encoding, rgb, TILE, &tile.data.len);
    uint8_t *bytes = tile.data.data;
    size_t count = tile.data.len;
    switch (server->variant) {
    case 0:
        tile.level = FILM_LEVELS;
        break;
    case 1:
        tile.level = UINT32_MAX;
        break;
    case 2:
        tile.x = WIDTH / TILE;
        break;
    case 3:
        tile.y = UINT32_MAX;
        break;
    case 4:
        tile.level = 2, tile.y = 1;
        break;
    case 5:
        tile.encoding = FOVEA__ENCODING__ENCODING_JPEG;
        break;
    case 6:
        tile.encoding = FOVEA__ENCODING__ENCODING_NONE;
        break;
    case 7:
        tile.encoding = (Fovea__Encoding)77;
        break;
    case 8:
        tile.data.len = 0;
        break;
    case 9:
        tile.data.len--;
        break;
    case 10:
        tile.generation = 0, tile.data.len--;
        break; /* the data is too short; refused even though the tile is not needed any more */
    }
    server_send(server, FOVEA__MESSAGE__BODY_TILE, &tile);
    if (count) free(bytes);
    server_until_gone(server);
}

static void bad_tiles(void **state)
{
    (void)state;
    static const char *const parts[] = {
        "level 3, column 0, row 0, where there is none",
        "level 4294967295",
        "column 8",
        "row 4294967295",
        "level 2, column 0, row 1",
        "encoding 2, which was not asked for",
        "encoding 0",
        "encoding 77",
        "0 bytes that are not a tile of 16 pixels",
        "that are not a tile",
        "that are not a tile",
    };
    for (int i = 0; i < 11; i++) assert_breaks(script_bad_tile, i, parts[i]);
}

static void script_out_of_place(struct server *server)
{
    Fovea__Gaze gaze = FOVEA__GAZE__INIT;
    Fovea__Freeze freeze = FOVEA__FREEZE__INIT;
    Fovea__Ping ping = FOVEA__PING__INIT;
    Fovea__Stats stats = FOVEA__STATS__INIT;
    Fovea__Done done = FOVEA__DONE__INIT;
    float numbers[] = {0, 0, -1, 0}, camera[] = {0, 1.6f, 0, 0};
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    gaze.direction = gaze.head = gaze.aim = numbers;
    gaze.n_direction = gaze.n_aim = 3;
    server_send(server, FOVEA__MESSAGE__BODY_GAZE, &gaze); /* this one is valid */
    switch (server->variant) {
    case 0:
        gaze.n_direction = 0;
        break;
    case 1:
        gaze.n_direction = 4;
        break;
    case 2:
        gaze.n_head = 3;
        break;
    case 3:
        numbers[1] = NAN;
        break;
    case 4:
        server_welcome(server);
        break;
    case 5:
        server_send(server, FOVEA__MESSAGE__BODY_FREEZE, &freeze);
        break;
    case 6:
        server_send(server, FOVEA__MESSAGE__BODY_PING, &ping);
        break;
    case 7:
        gaze.n_aim = 2;
        break;
    }
    stats.camera = done.camera = camera;
    stats.n_camera = done.n_camera = 3;
    stats.scene = stats.refused = "a\nb";
    server_send(server, FOVEA__MESSAGE__BODY_STATS, &stats); /* valid: the client only cleans the text */
    server_send(server, FOVEA__MESSAGE__BODY_DONE, &done);
    if (server->variant == 8) camera[2] = INFINITY;
    if (server->variant == 9) stats.n_camera = 2;
    if (server->variant == 10) done.n_camera = 4;
    if (server->variant >= 8) server_send(server, FOVEA__MESSAGE__BODY_STATS, &stats);
    if (server->variant >= 8) server_send(server, FOVEA__MESSAGE__BODY_DONE, &done);
    server_send(server, FOVEA__MESSAGE__BODY_GAZE, &gaze);
    server_until_gone(server);
}

static void out_of_place(void **state)
{
    (void)state;
    for (int i = 0; i <= 3; i++) assert_breaks(script_out_of_place, i, "a gaze of no direction");
    assert_breaks(script_out_of_place, 7, "a gaze of no direction");
    for (int i = 8; i <= 10; i++)
        assert_breaks(script_out_of_place, i, "an impossible position of the camera");
    assert_breaks(script_out_of_place, 4, "a message of kind 16 out of place");
    assert_breaks(script_out_of_place, 5, "a message of kind 4 out of place");
    assert_breaks(script_out_of_place, 6, "a message of kind 7 out of place");
}

static void script_half(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
    server_until(server, FOVEA__MESSAGE__BODY_PING);
    if (server->variant == 0) server_write(server, "\0\0\1\0abc", 7);
    if (server->variant == 1) server_write(server, "\0\0", 2);
    if (server->variant >= 3) { /* noise from a fixed seed */
        unsigned seed = (unsigned)server->variant;
        uint8_t bytes[2000];
        for (size_t i = 0; i < sizeof bytes; i++)
            bytes[i] = (uint8_t)((seed = seed * 1664525 + 1013904223) >> 24);
        bytes[0] = 0xff;
        server_write(server, bytes, sizeof bytes);
    }
    shutdown(server->fd, SHUT_WR);
    server_until_gone(server);
}

static void closes_in_the_middle(void **state)
{
    (void)state;
    assert_breaks(script_half, 0, "has closed the connection in the middle of a message");
    assert_breaks(script_half, 1, "has closed the connection in the middle of a message");
    assert_breaks(script_half, 2, "has closed the connection");
    for (int i = 3; i < 20; i++) assert_breaks(script_half, i, "bytes, where 8388608 is the limit");
}

/* --- sending --- */

static void script_leave(struct server *server)
{
    server_until(server, FOVEA__MESSAGE__BODY_HELLO);
    server_welcome(server);
}

static void sending_to_nobody(void **state)
{
    (void)state;
    struct server server = {.script = script_leave};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    Fovea__Save save = FOVEA__SAVE__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    char error[PRO_ERROR_SIZE] = "";
    assert_true(server_start(&server, false));
    struct pro_client *client = pro_connect(&server.address, &hello, PATIENCE_MS, false, error);
    assert_non_null(client);
    server_finish(&server);
    message.body_case = FOVEA__MESSAGE__BODY_SAVE;
    message.save = &save;
    save.path = calloc(1, PRO_MAX_TO_DAEMON + 1);
    memset(save.path, '/', PRO_MAX_TO_DAEMON);
    assert_false(pro_send(client, &message, error));
    assert_non_null(strstr(error, "where 65536 is the limit"));
    strcpy(save.path, "/x");
    assert_false(pro_send(client, &message, error));
    assert_non_null(strstr(error, "has closed the connection"));
    free(save.path);
    pro_disconnect(client);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stranger_hears_nothing),
        cmocka_unit_test(never_answers),
        cmocka_unit_test(absurd_welcome),
        cmocka_unit_test(wrong_first_word),
        cmocka_unit_test(bad_tiles),
        cmocka_unit_test(out_of_place),
        cmocka_unit_test(closes_in_the_middle),
        cmocka_unit_test(sending_to_nobody),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
