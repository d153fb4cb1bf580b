/* A daemon that misbehaves in one way: false_daemon PATH KIND. It listens on a Unix socket and welcomes one
 * client. KIND says what follows:
 *   gone      it closes the connection, like one that was killed
 *   torn      it does so in the middle of a message
 *   nonsense  it sends something that is not a message
 *   silent    it sends nothing
 *   partial   it sends the same tile of the finest level for ever, so that the picture is never whole */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "protocol.h"

enum { TILE = 16, PAUSE_MS = 10 };

static bool put(int fd, const void *bytes, size_t count)
{
    return send(fd, bytes, count, MSG_NOSIGNAL) == (ssize_t)count;
}

static bool say(int fd, Fovea__Message__BodyCase body, void *content)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    size_t count;
    uint8_t *frame;
    bool good;

    message.body_case = body;
    message.hello = content; /* the bodies are a union of pointers */
    frame = pro_pack(&message, 0, &count);
    good = frame && put(fd, frame, count);
    free(frame);
    return good;
}

static bool welcome(int fd)
{
    Fovea__Welcome body = FOVEA__WELCOME__INIT;

    body.version = PRO_VERSION;
    body.width = 128;
    body.height = 64;
    body.tile_size = TILE;
    body.levels = 3;
    body.generation = 1;
    return say(fd, FOVEA__MESSAGE__BODY_WELCOME, &body);
}

static bool send_tile(int fd, Fovea__Encoding encoding)
{
    static float grey[TILE * TILE * 3];
    Fovea__Tile body = FOVEA__TILE__INIT;
    static uint64_t serial;
    bool good;

    body.serial = ++serial;
    body.generation = 1;
    body.encoding = encoding;
    body.data.data = pro_encode(encoding, grey, TILE, &body.data.len);
    good = say(fd, FOVEA__MESSAGE__BODY_TILE, &body);
    free(body.data.data);
    return good;
}

/* Wait until the client has gone, whatever it sends. */
static void wait_for_end(int fd, bool tiles, Fovea__Encoding encoding)
{
    char bytes[4096];

    for (;;) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};

        if (poll(&wait, 1, tiles ? PAUSE_MS : -1) > 0 && read(fd, bytes, sizeof(bytes)) <= 0) return;
        if (tiles && !send_tile(fd, encoding)) return;
    }
}

/* The client's Hello. */
static Fovea__Encoding greeted(int fd)
{
    char bytes[4096], error[PRO_ERROR_SIZE];
    struct pro_reader reader;
    Fovea__Message *message = NULL;
    Fovea__Encoding encoding;

    pro_reader_init(&reader, PRO_MAX_TO_DAEMON);
    while (pro_reader_take(&reader, &message, error) == PRO_MORE) {
        ssize_t count = read(fd, bytes, sizeof(bytes));

        if (count <= 0 || !pro_reader_add(&reader, bytes, (size_t)count)) exit(1);
    }
    if (!message || message->body_case != FOVEA__MESSAGE__BODY_HELLO) exit(1);
    encoding = message->hello->tiles;
    fovea__message__free_unpacked(message, NULL);
    pro_reader_finish(&reader);
    return encoding;
}

int main(int argc, char **argv)
{
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    int listener = socket(AF_UNIX, SOCK_STREAM, 0), fd;
    Fovea__Encoding encoding;

    if (argc != 3) return 2;
    snprintf(name.sun_path, sizeof(name.sun_path), "%s", argv[1]);
    unlink(name.sun_path);
    if (listener < 0 || bind(listener, (struct sockaddr *)&name, sizeof(name)) || listen(listener, 1) ||
        (fd = accept(listener, NULL, NULL)) < 0)
        return perror(argv[1]), 1;
    encoding = greeted(fd);
    if (!welcome(fd)) return 1;
    if (!strcmp(argv[2], "torn")) put(fd, "\0\0\0\x20\x08", 5);
    if (!strcmp(argv[2], "nonsense")) put(fd, "\0\0\0\x04\xff\xff\xff\xff", 8);
    if (!strcmp(argv[2], "silent") || !strcmp(argv[2], "partial") || !strcmp(argv[2], "nonsense"))
        wait_for_end(fd, !strcmp(argv[2], "partial"), encoding);
    close(fd);
    return 0;
}
