/* A client that misbehaves in one way, named by its argument, and then waits for what the daemon does about
 * it. Status 0 if that is right: dropped, or for a deaf client kept. */
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "protocol.h"

/* The daemon waits five seconds for what is late; a loaded machine is forgiven all that a test may last. */
enum { PATIENCE_MS = 3600000 };

static int dial(const char *path)
{
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);

    snprintf(name.sun_path, sizeof(name.sun_path), "%s", path);
    if (fd < 0 || connect(fd, (struct sockaddr *)&name, sizeof(name))) {
        perror(path);
        exit(2);
    }
    return fd;
}

static void put(int fd, const void *bytes, size_t count)
{
    /* A daemon that has already hung up is what is wanted. */
    if (send(fd, bytes, count, MSG_NOSIGNAL) < 0 && errno != EPIPE && errno != ECONNRESET) perror("send");
}

static void say(int fd, Fovea__Message__BodyCase body, void *content)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    size_t count;
    uint8_t *frame;

    message.body_case = body;
    message.hello = content;
    frame = pro_pack(&message, 0, &count);
    put(fd, frame, count);
    free(frame);
}

static void hello(int fd, Fovea__Encoding tiles, uint32_t version)
{
    Fovea__Hello body = FOVEA__HELLO__INIT;

    body.version = version;
    body.client = "hostile";
    body.tiles = tiles;
    body.window = 1024;
    say(fd, FOVEA__MESSAGE__BODY_HELLO, &body);
}

/* 0 once the daemon has closed the connection; what it says before is let go. */
static int dropped(int fd)
{
    struct pollfd wait = {.fd = fd, .events = POLLIN};
    char bytes[65536];

    while (poll(&wait, 1, PATIENCE_MS) > 0)
        if (recv(fd, bytes, sizeof(bytes), 0) <= 0) return 0;
    fprintf(stderr, "still connected after %d ms\n", PATIENCE_MS);
    return 1;
}

static int noise(int fd)
{
    uint8_t bytes[100000];

    srand(7);
    for (size_t i = 0; i < sizeof(bytes); i++) bytes[i] = (uint8_t)(rand() >> 7);
    put(fd, bytes, sizeof(bytes));
    return dropped(fd);
}

static int length(int fd, const char *bytes)
{
    put(fd, bytes, 4);
    return dropped(fd);
}

/* Asks for everything and reads nothing: it must be left alone, and cost nobody anything. */
static int deaf(int fd)
{
    struct pollfd wait = {.fd = fd, .events = 0};

    hello(fd, FOVEA__ENCODING__ENCODING_HALF_ZSTD, PRO_VERSION);
    poll(&wait, 1, 8000);
    if (!(wait.revents & (POLLHUP | POLLERR))) return 0;
    fprintf(stderr, "a client that does not read was dropped\n");
    return 1;
}

/* As many clients as there is room for, and one more, which is told why it is turned away. */
static int crowd(const char *place)
{
    enum { ROOM = 64 };
    struct pro_client *client[ROOM + 1] = {NULL};
    Fovea__Hello body = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE] = "";
    struct pro_address address;
    int in = 0;

    if (!pro_address_parse(place, &address, error)) return 2;
    body.token = getenv("FOVEAD_TOKEN") ? getenv("FOVEAD_TOKEN") : "";
    while (in <= ROOM && (client[in] = pro_connect(&address, &body, PATIENCE_MS, false, error))) in++;
    for (int i = 0; i < in; i++) pro_disconnect(client[i]);
    if (in == ROOM && strstr(error, "refused: 64 clients are connected")) return 0;
    fprintf(stderr, "%s: %d clients came in, then: %s\n", place, in, error);
    return 1;
}

/* On a port of loopback as many connections as there is room for clients, of which none says anything: those
 * that would take the room of who needs no token are turned away. */
static int strangers(const char *place)
{
    enum { ROOM = 64 };
    struct sockaddr_in name = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd[ROOM], away = 0;

    name.sin_port = htons((uint16_t)atoi(strrchr(place, ':') + 1));
    for (int i = 0; i < ROOM; i++) {
        fd[i] = socket(AF_INET, SOCK_STREAM, 0);
        if (connect(fd[i], (struct sockaddr *)&name, sizeof(name))) return perror(place), 2;
    }
    for (int i = 0; i < ROOM; i++) {
        char said[512] = "";
        struct pollfd wait = {.fd = fd[i], .events = POLLIN};

        /* Whoever is in is dropped some time later, for another reason. */
        if (poll(&wait, 1, PATIENCE_MS) == 1 && recv(fd[i], said, sizeof(said) - 1, 0) > 0)
            away += memmem(said, sizeof(said), "have shown no token", 19) != NULL;
    }
    for (int i = 0; i < ROOM; i++) close(fd[i]);
    if (away == 48) return 0;
    fprintf(stderr, "%d of %d were turned away, where 48 were expected\n", away, ROOM);
    return 1;
}

/* Asks without end and reads nothing: dropped, or not listened to any more; either way it takes no memory. */
static int flood(int fd)
{
    struct timeval patience = {.tv_sec = 3};
    Fovea__Ping ping = FOVEA__PING__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    size_t count;
    uint8_t *frame;
    ssize_t sent;

    hello(fd, FOVEA__ENCODING__ENCODING_NONE, PRO_VERSION);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
    message.body_case = FOVEA__MESSAGE__BODY_PING;
    message.ping = &ping;
    frame = pro_pack(&message, 0, &count);
    do sent = send(fd, frame, count, MSG_NOSIGNAL);
    while (sent == (ssize_t)count);
    free(frame);
    return 0;
}

/* A view that has no orientation, or a place on the screen of three numbers, of no area, or out of reach. */
static void wrong_view(int fd, const char *how)
{
    Fovea__View view = FOVEA__VIEW__INIT;
    float nothing[4] = {0, 0, 0, 0}, ahead[4] = {0, 0, 0, 1}, far[4] = {3e38f, 0, 1, 1};

    view.n_orientation = 4;
    view.orientation = !strcmp(how, "view") ? nothing : ahead;
    view.fov_x = view.fov_y = 1;
    view.n_screen = !strcmp(how, "view") ? 0 : !strcmp(how, "view-corner") ? 3 : 4;
    view.screen = !strcmp(how, "view-far") ? far : nothing;
    hello(fd, FOVEA__ENCODING__ENCODING_NONE, PRO_VERSION);
    say(fd, FOVEA__MESSAGE__BODY_VIEW, &view);
}

static int wrong(int fd, const char *how)
{
    Fovea__Acknowledge acknowledge = FOVEA__ACKNOWLEDGE__INIT;
    Fovea__Welcome welcome = FOVEA__WELCOME__INIT;
    Fovea__Recentre recentre = FOVEA__RECENTRE__INIT;
    Fovea__Move move = FOVEA__MOVE__INIT;
    float nothing[4] = {0, 0, 0, 0}, camera[3] = {0, 1.6f, !strcmp(how, "nan") ? NAN : 3e38f};

    if (!strcmp(how, "version")) hello(fd, FOVEA__ENCODING__ENCODING_NONE, 99);
    if (!strcmp(how, "encoding")) hello(fd, (Fovea__Encoding)77, PRO_VERSION);
    if (!strcmp(how, "half") || !strcmp(how, "serial") || !strcmp(how, "welcome") ||
        !strcmp(how, "recentre") || !strcmp(how, "nowhere") || !strcmp(how, "nan") || !strcmp(how, "far") ||
        !strcmp(how, "flat"))
        hello(fd, FOVEA__ENCODING__ENCODING_NONE, PRO_VERSION);
    acknowledge.serial = 1000000;
    if (!strcmp(how, "serial") || !strcmp(how, "early"))
        say(fd, FOVEA__MESSAGE__BODY_ACKNOWLEDGE, &acknowledge);
    if (!strcmp(how, "welcome")) say(fd, FOVEA__MESSAGE__BODY_WELCOME, &welcome);
    if (!strncmp(how, "view", 4)) wrong_view(fd, how);
    recentre.direction = nothing;
    recentre.n_direction = !strcmp(how, "recentre") ? 4 : 3;
    if (!strcmp(how, "recentre") || !strcmp(how, "nowhere"))
        say(fd, FOVEA__MESSAGE__BODY_RECENTRE, &recentre);
    move.camera = camera;
    move.n_camera = !strcmp(how, "flat") ? 2 : 3;
    move.relative = !strcmp(how, "far");
    if (!strcmp(how, "nan") || !strcmp(how, "far") || !strcmp(how, "flat"))
        say(fd, FOVEA__MESSAGE__BODY_MOVE, &move);
    if (!strcmp(how, "half")) put(fd, "\0\0\0\100half", 8);
    return dropped(fd); /* "silent" has said nothing at all */
}

int main(int argc, char **argv)
{
    int fd;

    if (argc != 3) return 2;
    if (!strcmp(argv[2], "crowd")) return crowd(argv[1]);
    if (!strcmp(argv[2], "strangers")) return strangers(argv[1]);
    fd = dial(argv[1]);
    if (!strcmp(argv[2], "noise")) return noise(fd);
    if (!strcmp(argv[2], "huge")) return length(fd, "\200\0\0\0");
    if (!strcmp(argv[2], "over")) return length(fd, "\0\1\0\1");
    if (!strcmp(argv[2], "zero")) return length(fd, "\0\0\0\0");
    if (!strcmp(argv[2], "deaf")) return deaf(fd);
    if (!strcmp(argv[2], "flood")) return flood(fd);
    return wrong(fd, argv[2]);
}
