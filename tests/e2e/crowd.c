/* Many clients of fovead at once, by raw sockets and by WebSocket on two ports of loopback.
 *
 * crowd come HTTP TCP COUNT: so many connections to each port, which end in one of several ways at once.
 * crowd stay HTTP TCP: 50 clients. 10 of them ask for tiles and read nothing, 2 read as slowly as a link of 1
 * Mbit/s lets them, and the others read as fast as they can. All but the 10 must get their tiles, and paths
 * must go on. */
#include <endian.h>
#include <pthread.h>
#include <time.h>

#include "browser.h"
#include "protocol.h"

enum {
    DEAF = 10,
    SLOW = 2,
    ALL = 50,
    READERS = ALL - DEAF,
    TILES = 150,     /* that a client must get: more than the coarse levels of the film have */
    SLOW_TILES = 20, /* that a slow one must get */
    SLOW_BYTES = 1250,
    SLOW_NS = 10000000 /* 125,000 bytes per second */
};

struct peer {
    int fd;
    bool is_web, is_slow;
    pthread_t thread;
};

static void fail(const char *what)
{
    fprintf(stderr, "crowd: %s\n", what);
    exit(1);
}

/* Read exactly so many bytes. False if the connection has ended. */
static bool take(const struct peer *peer, void *bytes, size_t count)
{
    for (size_t taken = 0; taken < count;) {
        size_t most = count - taken;

        if (peer->is_slow) {
            nanosleep(&(struct timespec){.tv_nsec = SLOW_NS}, NULL);
            if (most > SLOW_BYTES) most = SLOW_BYTES;
        }
        const ssize_t got = recv(peer->fd, (char *)bytes + taken, most, 0);
        if (got <= 0) return false;
        taken += (size_t)got;
    }
    return true;
}

static void say(const struct peer *peer, Fovea__Message__BodyCase body, void *content)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    uint8_t *bytes, frame[1024];
    size_t count;

    message.body_case = body;
    message.hello = content;
    bytes = pro_pack_message(&message, PRO_PREFIX, &count);
    if (!bytes || count > sizeof(frame) - BROWSER_FRAME_HEADER) fail("out of memory");
    pro_put_length(bytes, count);
    if (peer->is_web)
        send(peer->fd, frame, browser_frame(0x82, bytes + PRO_PREFIX, count, frame), MSG_NOSIGNAL);
    else
        send(peer->fd, bytes, PRO_PREFIX + count, MSG_NOSIGNAL);
    free(bytes);
}

/* The next message, for the caller to free; NULL if the connection has ended. */
static Fovea__Message *hear(const struct peer *peer)
{
    uint8_t head[4], *bytes;
    uint64_t count = 0;
    uint16_t shorter;
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message;

    if (peer->is_web) {
        if (!take(peer, head, 2)) return NULL;
        count = head[1];
        if (head[0] != 0x82 || count > 127) fail("a frame that is no whole binary message");
        if (count == 126) {
            if (!take(peer, &shorter, sizeof(shorter))) return NULL;
            count = be16toh(shorter);
        } else if (count == 127) {
            if (!take(peer, &count, sizeof(count))) return NULL;
            count = be64toh(count);
        }
    } else {
        if (!take(peer, head, sizeof(head))) return NULL;
        count = (uint64_t)head[0] << 24 | (uint64_t)head[1] << 16 | (uint64_t)head[2] << 8 | head[3];
    }
    if (count > PRO_MAX_TO_CLIENT || !(bytes = malloc(count + 1))) fail("a message that is too long");
    message = take(peer, bytes, count) ? pro_unpack_message(bytes, count, error) : NULL;
    free(bytes);
    return message;
}

/* Connect; by WebSocket until it is open. */
static void dial(struct peer *peer, int port, bool is_web)
{
    char text[1024], last[4] = "", byte;

    *peer = (struct peer){
        .fd = browser_dial(port, peer->is_slow ? 4096 : 0), .is_web = is_web, .is_slow = peer->is_slow};
    if (!is_web) return;
    send(peer->fd, text, browser_handshake(port, text, sizeof(text)), MSG_NOSIGNAL);
    while (memcmp(last, "\r\n\r\n", sizeof(last))) {
        if (recv(peer->fd, &byte, 1, 0) != 1) fail("no WebSocket");
        memmove(last, last + 1, sizeof(last) - 1);
        last[sizeof(last) - 1] = byte;
    }
}

static void greet(const struct peer *peer, bool wants_tiles)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;

    hello.version = PRO_VERSION;
    hello.client = (char *)"crowd";
    hello.stats = !wants_tiles;
    if (wants_tiles)
        hello.tiles = peer->is_web ? FOVEA__ENCODING__ENCODING_RGB9E5 : FOVEA__ENCODING__ENCODING_HALF_ZSTD;
    say(peer, FOVEA__MESSAGE__BODY_HELLO, &hello);
}

/* --- connections that come and go --- */

/* End a connection as a crash would: the other side's next write fails. */
static void reset(int fd)
{
    const struct linger now = {.l_onoff = 1};

    setsockopt(fd, SOL_SOCKET, SO_LINGER, &now, sizeof(now));
    close(fd);
}

static void come_and_go(int port, bool is_web, int way)
{
    const char *part = is_web ? "GET / HTTP/1.1\r\nHos" : "\0\0";
    struct peer peer = {.is_slow = false};

    switch (way) {
    case 0:
        close(browser_dial(port, 0));
        return;
    case 1:
        peer.fd = browser_dial(port, 0);
        send(peer.fd, part, is_web ? strlen(part) : 2, MSG_NOSIGNAL);
        close(peer.fd);
        return;
    case 2:
        dial(&peer, port, is_web);
        close(peer.fd);
        return;
    case 3:
        dial(&peer, port, is_web);
        greet(&peer, true);
        close(peer.fd);
        return;
    default: {
        Fovea__Message *message;

        dial(&peer, port, is_web);
        greet(&peer, true);
        message = hear(&peer);
        if (!message || message->body_case != FOVEA__MESSAGE__BODY_WELCOME) fail("a client was not welcome");
        fovea__message__free_unpacked(message, NULL);
        reset(peer.fd);
        return;
    }
    }
}

/* --- clients that stay --- */

static void *read_tiles(void *argument)
{
    const struct peer *peer = argument;
    const int wanted = peer->is_slow ? SLOW_TILES : TILES;

    for (int tiles = 0; tiles < wanted;) {
        Fovea__Acknowledge acknowledge = FOVEA__ACKNOWLEDGE__INIT;
        Fovea__Message *message = hear(peer);

        if (!message) fail("a client that reads was dropped");
        if (message->body_case == FOVEA__MESSAGE__BODY_TILE) {
            acknowledge.serial = message->tile->serial;
            say(peer, FOVEA__MESSAGE__BODY_ACKNOWLEDGE, &acknowledge);
            tiles++;
        }
        fovea__message__free_unpacked(message, NULL);
    }
    return NULL;
}

/* Paths in all so far, by the next statistics. */
static uint64_t paths(const struct peer *peer)
{
    uint64_t samples = 0;

    for (bool told = false; !told;) {
        Fovea__Message *message = hear(peer);

        if (!message) fail("no statistics");
        told = message->body_case == FOVEA__MESSAGE__BODY_STATS;
        if (told) samples = message->stats->samples;
        fovea__message__free_unpacked(message, NULL);
    }
    return samples;
}

static int stay(int http, int tcp)
{
    static struct peer deaf[DEAF], reader[READERS];
    struct peer judge = {.is_slow = false};
    uint64_t before;

    for (int i = 0; i < DEAF; i++) {
        dial(&deaf[i], i % 2 ? http : tcp, i % 2);
        greet(&deaf[i], true);
    }
    for (int i = 0; i < READERS; i++) {
        reader[i].is_slow = i < SLOW;
        dial(&reader[i], i % 2 ? http : tcp, i % 2);
        greet(&reader[i], true);
    }
    for (int i = 0; i < READERS; i++)
        if (pthread_create(&reader[i].thread, NULL, read_tiles, &reader[i])) fail("no thread can be made");
    for (int i = SLOW; i < READERS; i++) pthread_join(reader[i].thread, NULL);
    /* The deaf clients are full by now, and the slow ones may be. */
    dial(&judge, tcp, false);
    greet(&judge, false);
    before = paths(&judge);
    while (paths(&judge) <= before) continue;
    for (int i = 0; i < SLOW; i++) pthread_join(reader[i].thread, NULL);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 5 && !strcmp(argv[1], "come")) {
        for (int i = 0; i < atoi(argv[4]); i++) {
            come_and_go(atoi(argv[2]), true, i % 5);
            come_and_go(atoi(argv[3]), false, i % 5);
        }
        return 0;
    }
    if (argc == 4 && !strcmp(argv[1], "stay")) return stay(atoi(argv[2]), atoi(argv[3]));
    return 2;
}
