/* garble SOCKET PID PORT KIND COUNT: sends COUNT inputs to a port on which fovead, process PID, listens for
 * browsers. Each was right before it was changed at random, always in the same ways. KIND: requests,
 * handshakes and frames of WebSocket, or the beginning of TLS. fovead must end each connection once its input
 * has ended, go on serving an honest client on SOCKET, and keep neither descriptors nor memory. */
#include <dirent.h>
#include <poll.h>

#include <openssl/ssl.h>

#include "../sanitized.h"
#include "browser.h"
#include "protocol.h"

enum { ROOM = 1 << 18, BETWEEN = 50 /* inputs between two questions of the honest client */ };

struct input {
    uint8_t bytes[ROOM];
    size_t count;
};

static uint64_t state = 0x9e3779b97f4a7c15;

/* A number below the limit (xorshift64*, Vigna 2016). */
static size_t draw(size_t limit)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (size_t)((state * 0x2545f4914f6cdd1d) >> 33) % limit;
}

/* --- what is right --- */

static void add(struct input *input, const void *bytes, size_t count)
{
    if (input->count + count > ROOM) count = ROOM - input->count;
    memcpy(input->bytes + input->count, bytes, count);
    input->count += count;
}

static const char *const REQUESTS[] = {
    "GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n",
    "GET /main.js HTTP/1.1\r\nHost: localhost:%d\r\nAccept: */*\r\nUser-Agent: garble\r\nCookie: a=b; "
    "c=d\r\n\r\n",
    "HEAD / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nIf-None-Match: \"a\"\r\nRange: bytes=0-9\r\n\r\n",
    "POST / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Length: 5\r\nContent-Type: text/plain\r\n\r\nhello",
    "PUT /x HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n",
    "OPTIONS * HTTP/1.0\r\nHost: [::1]:%d\r\nConnection: keep-alive\r\n\r\nGET /style.css HTTP/1.1\r\nHost: "
    "[::1]\r\n\r\n",
    "GET /?a=%%41&b=%%zz#c HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nOrigin: null\r\nReferer: http://a/\r\n\r\n",
    "GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nUpgrade: h2c\r\nConnection: Upgrade, HTTP2-Settings\r\n"
    "HTTP2-Settings: AAMAAABkAAQAAP__\r\n\r\n",
    "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n%d",
};

static void add_request(struct input *input, int port)
{
    char text[1024];

    add(input, text,
        (size_t)snprintf(text, sizeof(text), REQUESTS[draw(sizeof(REQUESTS) / sizeof(*REQUESTS))], port));
}

static void add_handshake(struct input *input, int port)
{
    char text[1024];

    add(input, text, browser_handshake(port, text, sizeof(text)));
}

static void add_frame(struct input *input, int opcode, const uint8_t *payload, size_t count)
{
    static uint8_t frame[ROOM];

    add(input, frame, browser_frame(opcode, payload, count, frame));
}

static void add_message(struct input *input, Fovea__Message__BodyCase body, void *content)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    uint8_t *bytes;
    size_t count, half;

    message.body_case = body;
    message.hello = content;
    bytes = pro_pack_message(&message, 0, &count);
    if (draw(4)) {
        add_frame(input, 0x82, bytes, count);
    } else {
        half = draw(count + 1);
        add_frame(input, 0x02, bytes, half);
        if (draw(2)) add_frame(input, 0x89, (const uint8_t *)"ping", 4);
        add_frame(input, 0x80, bytes + half, count - half);
    }
    free(bytes);
}

/* Hello, which may ask for everything, and some of what a page sends then. */
static void add_messages(struct input *input)
{
    static const uint8_t zeros[70000], closing[] = {3, 0xe8, 'b', 'y', 'e'};
    float numbers[4] = {0, 0, -1, 0};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    Fovea__View view = FOVEA__VIEW__INIT;
    Fovea__Pointer pointer = FOVEA__POINTER__INIT;
    Fovea__Acknowledge acknowledge = FOVEA__ACKNOWLEDGE__INIT;
    Fovea__Ping ping = FOVEA__PING__INIT;

    hello.version = PRO_VERSION;
    hello.client = (char *)"garble";
    hello.tiles = (Fovea__Encoding)draw(4);
    hello.gaze = draw(2);
    hello.stats = draw(2);
    view.orientation = numbers;
    view.n_orientation = 4;
    view.fov_x = view.fov_y = 1;
    pointer.direction = numbers;
    pointer.n_direction = 3;
    add_message(input, FOVEA__MESSAGE__BODY_HELLO, &hello);
    for (size_t i = draw(6); i > 0; i--) {
        switch (draw(7)) {
        case 0:
            add_message(input, FOVEA__MESSAGE__BODY_VIEW, &view);
            break;
        case 1:
            add_message(input, FOVEA__MESSAGE__BODY_POINTER, &pointer);
            break;
        case 2:
            add_message(input, FOVEA__MESSAGE__BODY_ACKNOWLEDGE, &acknowledge);
            break;
        case 3:
            add_message(input, FOVEA__MESSAGE__BODY_PING, &ping);
            break;
        case 4:
            add_frame(input, 0x8a, (const uint8_t *)"pong", 4);
            break;
        case 5:
            add_frame(input, 0x88, closing, sizeof(closing));
            break;
        default:
            add_frame(input, 0x82, zeros, draw(2) ? draw(300) : draw(sizeof(zeros)));
            break;
        }
    }
}

/* What OpenSSL would send first. */
static void add_tls(struct input *input)
{
    SSL_CTX *context = SSL_CTX_new(TLS_client_method());
    SSL *tls = context ? SSL_new(context) : NULL;
    BIO *in = BIO_new(BIO_s_mem()), *out = BIO_new(BIO_s_mem());
    char *bytes;

    if (!tls || !in || !out) exit(2);
    SSL_set_bio(tls, in, out);
    SSL_set_tlsext_host_name(tls, draw(2) ? "localhost" : "raw");
    SSL_set_alpn_protos(tls, (const unsigned char *)"\2h2\10http/1.1", 12);
    SSL_connect(tls);
    add(input, bytes, (size_t)BIO_get_mem_data(out, &bytes));
    SSL_free(tls);
    SSL_CTX_free(context);
}

/* --- what is wrong --- */

/* Put count bytes into the place of removed bytes at a place. */
static void replace(struct input *input, size_t at, size_t removed, const void *bytes, size_t count)
{
    if (input->count - removed + count > ROOM) return;
    memmove(input->bytes + at + count, input->bytes + at + removed, input->count - at - removed);
    memcpy(input->bytes + at, bytes, count);
    input->count += count - removed;
}

static void change(struct input *input, size_t from)
{
    static const char *const WORDS[] = {
        "\r\n",
        "\r\n\r\n",
        "\n",
        ":",
        " ",
        "%",
        "%00",
        "Host: ",
        "Upgrade: websocket\r\n",
        "Connection: Upgrade\r\n",
        "Content-Length: 99999999999999999999\r\n",
        "Transfer-Encoding: chunked\r\n",
        "Sec-WebSocket-Extensions: permessage-deflate\r\n",
        "HTTP/1.1",
        "GET ",
        "\xff\xff\xff\xff\xff\xff\xff\xff",
        "\x7f\xff",
        "../../../../etc/passwd",
    };
    static char run[ROOM / 2];
    const size_t left = input->count - from, at = from + (left ? draw(left) : 0);
    const char *word = WORDS[draw(sizeof(WORDS) / sizeof(*WORDS))];
    size_t length = input->count - at;
    uint8_t byte = (uint8_t)draw(256);

    if (length > 1) length = 1 + draw(length < 64 ? length : 64);
    switch (draw(9)) {
    case 0:
    case 1:
        if (length) input->bytes[at] ^= (uint8_t)(1 << draw(8));
        break;
    case 2:
        if (length) input->bytes[at] = byte;
        break;
    case 3:
        replace(input, at, 0, &byte, 1);
        break;
    case 4:
        replace(input, at, length, "", 0);
        break;
    case 5:
        replace(input, at, 0, word, strlen(word));
        break;
    case 6:
        replace(input, at, length, word, strlen(word));
        break;
    case 7:
        memcpy(run, input->bytes + at, length);
        replace(input, at, 0, run, length);
        break;
    default:
        if (draw(4)) {
            input->count = at;
        } else {
            memset(run, 'a' + (int)draw(26), sizeof(run));
            replace(input, at, 0, run, draw(sizeof(run)));
        }
        break;
    }
}

static bool make(struct input *input, const char *kind, int port)
{
    size_t from = 0;

    input->count = 0;
    if (!strcmp(kind, "requests")) {
        for (size_t i = 1 + draw(3); i > 0; i--) add_request(input, port);
    } else if (!strcmp(kind, "handshakes")) {
        add_handshake(input, port);
        add_messages(input);
    } else if (!strcmp(kind, "frames")) {
        add_handshake(input, port);
        from = input->count;
        add_messages(input);
    } else if (!strcmp(kind, "tls")) {
        add_tls(input);
    } else {
        return false;
    }
    for (size_t i = 1 + draw(8); i > 0; i--) change(input, from);
    return true;
}

/* --- fovead --- */

/* Send the input, end, and read until fovead has ended too. */
static void give(const struct input *input, int port)
{
    const int fd = browser_dial(port, 0);
    size_t sent = 0;
    bool ended = false;

    for (;;) {
        struct pollfd wait = {.fd = fd, .events = (short)(POLLIN | (ended ? 0 : POLLOUT))};
        char unread[65536];

        if (poll(&wait, 1, 1000 * BROWSER_PATIENCE_S) != 1) {
            fprintf(stderr, "fovead has not ended a connection\n");
            exit(1);
        }
        if (wait.revents & (POLLIN | POLLERR | POLLHUP) && recv(fd, unread, sizeof(unread), 0) <= 0) break;
        if (ended || !(wait.revents & POLLOUT)) continue;
        const ssize_t count = sent < input->count ? send(fd, input->bytes + sent, input->count - sent,
                                                         MSG_NOSIGNAL | MSG_DONTWAIT)
                                                  : 0;
        if (count > 0) sent += (size_t)count;
        ended = sent == input->count || (count < 0 && errno != EAGAIN);
        if (ended) shutdown(fd, SHUT_WR);
    }
    close(fd);
}

/* The honest client asks, and is answered. */
static void ask(struct pro_client *client)
{
    static uint64_t asked = UINT64_MAX / 2; /* the client's library sends other numbers */
    Fovea__Message message = FOVEA__MESSAGE__INIT, *answer;
    Fovea__Ping ping = FOVEA__PING__INIT;
    char error[PRO_ERROR_SIZE];
    bool is_answered = false;

    ping.client_ns = ++asked;
    message.body_case = FOVEA__MESSAGE__BODY_PING;
    message.ping = &ping;
    if (!pro_send(client, &message, error)) fprintf(stderr, "%s\n", error), exit(1);
    while (!is_answered) {
        if (pro_receive(client, 1000 * BROWSER_PATIENCE_S, &answer, error) != PRO_MESSAGE)
            fprintf(stderr, "the honest client: %s\n", error), exit(1);
        is_answered = answer->body_case == FOVEA__MESSAGE__BODY_PONG && answer->pong->client_ns == asked;
        fovea__message__free_unpacked(answer, NULL);
    }
}

static int descriptors(const char *process)
{
    char path[64];
    DIR *folder;
    int count = 0;

    snprintf(path, sizeof(path), "/proc/%s/fd", process);
    folder = opendir(path);
    if (!folder) perror(path), exit(1);
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

/* Memory that a process has for itself, KiB. */
static long memory(const char *process)
{
    char path[64], line[256];
    long kib = -1;
    FILE *file;

    snprintf(path, sizeof(path), "/proc/%s/status", process);
    file = fopen(path, "r");
    while (file && fgets(line, sizeof(line), file)) sscanf(line, "RssAnon: %ld", &kib);
    if (file) fclose(file);
    return kib;
}

int main(int argc, char **argv)
{
    static struct input input;
    const int port = argc == 6 ? atoi(argv[3]) : 0, count = argc == 6 ? atoi(argv[5]) : 0;
    struct pro_address address;
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE];
    struct pro_client *client;
    long before = 0, after;
    int open;

    if (argc != 6 || !pro_address_parse(argv[1], &address, error)) return 2;
    hello.tiles = FOVEA__ENCODING__ENCODING_JPEG;
    client = pro_connect(&address, &hello, -1, false, error);
    if (!client) return fprintf(stderr, "%s\n", error), 1;
    open = descriptors(argv[2]);
    for (int i = 0; i < count; i++) {
        if (!make(&input, argv[4], port)) return 2;
        give(&input, port);
        if (i % BETWEEN == 0) ask(client);
        if (i == count / 4) before = memory(argv[2]); /* until then there is much that is done once */
    }
    ask(client);
    after = memory(argv[2]);
    for (int i = 0; descriptors(argv[2]) > open; i++) {
        if (i == 6000)
            return fprintf(stderr, "fovead keeps %d descriptors\n", descriptors(argv[2]) - open), 1;
        usleep(10000);
    }
    pro_disconnect(client);
    printf("%s: %d inputs, memory from %ld to %ld KiB\n", argv[4], count, before, after);
    /* What is kept of one message would be seen; sanitizers keep what was freed. */
    if (SANITIZED || after - before < 1024 + count) return 0;
    fprintf(stderr, "%s: fovead has grown from %ld to %ld KiB\n", argv[4], before, after);
    return 1;
}
