/* protocol_server.h: a daemon of a few lines for the tests of the client. It has one thread, takes one
 * connection and follows one script.
 *
 * The script runs in the daemon's thread, where cmocka cannot assert. It notes in the server what it sees,
 * and the test checks that after server_finish(). */
#ifndef FOVEAD_PROTOCOL_SERVER_H
#define FOVEAD_PROTOCOL_SERVER_H

#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "protocol.h"

enum { WIDTH = 128, HEIGHT = 64, TILE = 16, FILM_LEVELS = 3, PATIENCE_MS = 3600000 };

struct server {
    struct pro_address address; /* where it listens */
    void (*script)(struct server *server);
    bool is_late;           /* it does not listen before may_listen */
    atomic_bool may_listen; /* set by the test */
    int variant;            /* for the script */
    int listener, fd;
    struct pro_reader reader;
    pthread_t thread;
    char folder[64];
    /* What the script has seen. */
    Fovea__Hello hello;
    char client[64];
    unsigned acknowledges, pings, freezes, others;
    uint64_t acknowledged;
    bool went_back; /* an acknowledgement was lower than the one before */
};

static inline void server_pause(int ms)
{
    struct timespec pause = {ms / 1000, ms % 1000 * 1000000L};
    nanosleep(&pause, NULL);
}

static inline uint64_t server_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* Returns false if the client has gone. */
static inline bool server_write(struct server *server, const void *bytes, size_t count)
{
    const char *next = bytes;
    while (count > 0) {
        ssize_t sent = send(server->fd, next, count, MSG_NOSIGNAL);
        if (sent <= 0) return false;
        next += sent;
        count -= (size_t)sent;
    }
    return true;
}

static inline bool server_send(struct server *server, Fovea__Message__BodyCase kind, void *body)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    size_t count;
    message.body_case = kind;
    message.hello = body; /* the members of the union are pointers */
    uint8_t *bytes = pro_pack(&message, 0, &count);
    bool ok = bytes && server_write(server, bytes, count);
    free(bytes);
    return ok;
}

static inline Fovea__Welcome server_film(void)
{
    Fovea__Welcome welcome = FOVEA__WELCOME__INIT;
    welcome.version = PRO_VERSION;
    welcome.server = "test";
    welcome.width = WIDTH;
    welcome.height = HEIGHT;
    welcome.tile_size = TILE;
    welcome.levels = FILM_LEVELS;
    welcome.generation = 1;
    return welcome;
}

static inline bool server_welcome(struct server *server)
{
    Fovea__Welcome welcome = server_film();
    return server_send(server, FOVEA__MESSAGE__BODY_WELCOME, &welcome);
}

/* A tile of one value. */
static inline bool server_tile(struct server *server, uint64_t serial, uint64_t generation, uint32_t level,
                               uint32_t x, uint32_t y, float value)
{
    Fovea__Tile tile = FOVEA__TILE__INIT;
    float rgb[TILE * TILE * 3];
    for (int i = 0; i < TILE * TILE * 3; i++) rgb[i] = value;
    tile.serial = serial;
    tile.generation = generation;
    tile.level = level;
    tile.x = x;
    tile.y = y;
    tile.encoding = server->hello.tiles;
    tile.data.data = pro_encode(tile.encoding, rgb, TILE, &tile.data.len);
    bool ok = server_send(server, FOVEA__MESSAGE__BODY_TILE, &tile);
    free(tile.data.data);
    return ok;
}

static inline void server_note(struct server *server, const Fovea__Message *message)
{
    Fovea__Pong pong = FOVEA__PONG__INIT;
    switch (message->body_case) {
    case FOVEA__MESSAGE__BODY_HELLO:
        server->hello = *message->hello;
        snprintf(server->client, sizeof server->client, "%s", message->hello->client);
        break;
    case FOVEA__MESSAGE__BODY_ACKNOWLEDGE:
        server->acknowledges++;
        server->went_back |= message->acknowledge->serial <= server->acknowledged;
        server->acknowledged = message->acknowledge->serial;
        break;
    case FOVEA__MESSAGE__BODY_PING:
        server->pings++;
        pong.client_ns = message->ping->client_ns;
        pong.daemon_ns = server_now_ns() + 1000000000000; /* the daemon's clock is 1000 s ahead */
        server_send(server, FOVEA__MESSAGE__BODY_PONG, &pong);
        break;
    case FOVEA__MESSAGE__BODY_FREEZE:
        server->freezes++;
        break;
    default:
        server->others++;
    }
}

/* Read messages and note them, up to and including the first of this kind. Returns false if the client has
 * gone. */
static inline bool server_until(struct server *server, Fovea__Message__BodyCase kind)
{
    for (;;) {
        char error[PRO_ERROR_SIZE];
        uint8_t bytes[4096];
        Fovea__Message *message;
        enum pro_result result = pro_reader_take(&server->reader, &message, error);
        if (result == PRO_BROKEN) return false;
        if (result == PRO_MESSAGE) {
            bool found = message->body_case == kind;
            server_note(server, message);
            fovea__message__free_unpacked(message, NULL);
            if (found) return true;
            continue;
        }
        struct pollfd poll_fd = {.fd = server->fd, .events = POLLIN};
        if (poll(&poll_fd, 1, PATIENCE_MS) != 1) return false;
        ssize_t count = recv(server->fd, bytes, sizeof bytes, 0);
        if (count <= 0 || !pro_reader_add(&server->reader, bytes, (size_t)count)) return false;
    }
}

static inline void server_until_gone(struct server *server)
{
    while (server_until(server, FOVEA__MESSAGE__BODY__NOT_SET)) continue;
}

static inline void *server_run(void *argument)
{
    struct server *server = argument;
    if (server->is_late) {
        while (!atomic_load(&server->may_listen)) server_pause(1);
        server_pause(150);
        listen(server->listener, 4);
    }
    struct pollfd poll_fd = {.fd = server->listener, .events = POLLIN};
    if (poll(&poll_fd, 1, PATIENCE_MS) != 1) return NULL;
    server->fd = accept(server->listener, NULL, NULL);
    if (server->fd < 0) return NULL;
    server->script(server);
    close(server->fd);
    return NULL;
}

/* Bind and start; server->address is where it listens. Returns false if that fails. */
static inline bool server_start(struct server *server, bool tcp)
{
    server->address = (struct pro_address){.is_unix = !tcp};
    server->fd = -1;
    pro_reader_init(&server->reader, PRO_MAX_TO_DAEMON);
    server->listener = socket(tcp ? AF_INET : AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (server->listener < 0) return false;
    bool bound;
    if (tcp) {
        struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
        socklen_t size = sizeof at;
        bound = bind(server->listener, (struct sockaddr *)&at, sizeof at) == 0 &&
                getsockname(server->listener, (struct sockaddr *)&at, &size) == 0;
        strcpy(server->address.host, "127.0.0.1");
        server->address.port = ntohs(at.sin_port);
    } else {
        struct sockaddr_un at = {.sun_family = AF_UNIX};
        strcpy(server->folder, "/tmp/fovea-test-XXXXXX");
        if (!mkdtemp(server->folder)) return false;
        snprintf(at.sun_path, sizeof at.sun_path, "%s/socket", server->folder);
        strcpy(server->address.path, at.sun_path);
        bound = bind(server->listener, (struct sockaddr *)&at, sizeof at) == 0;
    }
    if (!bound || (!server->is_late && listen(server->listener, 4) != 0)) return false;
    return pthread_create(&server->thread, NULL, server_run, server) == 0;
}

/* Wait for the script's end and clean up. */
static inline void server_finish(struct server *server)
{
    pthread_join(server->thread, NULL);
    close(server->listener);
    pro_reader_finish(&server->reader);
    if (server->address.is_unix) {
        unlink(server->address.path);
        rmdir(server->folder);
    }
}

#endif
