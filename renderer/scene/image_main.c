/* fovead-image: decodes pictures for a program that does not trust them; see image_program.h. Nobody types
 * its name. Descriptor 3 is the socket to that program. */
#include "scene/image_io.h"
#include "scene/image_packet.h"
#include "import/reader.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { CONTROL = 3, MOST_COPIES = 1024 };

/* --- a copy --- */

struct sender {
    struct rnd_pixels_sink sink; /* first */
    int socket;
    size_t row; /* bytes */
    bool size_only, begun;
};

static bool send_begin(struct rnd_pixels_sink *sink, const struct rnd_picture *picture)
{
    struct sender *sender = (struct sender *)(void *)sink;
    sender->row = (size_t)picture->width * (size_t)picture->channels * (picture->bytes ? 1 : sizeof(float));
    sender->begun = rnd_image_send(sender->socket, RND_IMAGE_BEGIN, picture, sizeof *picture, -1);
    return sender->begun && !sender->size_only;
}

static bool send_rows(struct rnd_pixels_sink *sink, int first, int count, const void *pixels)
{
    const struct sender *sender = (const struct sender *)(const void *)sink;
    const size_t all = (size_t)count * sender->row;
    (void)first;
    for (size_t at = 0, n; at < all; at += n) {
        n = all - at < RND_IMAGE_PACKET_BYTES ? all - at : RND_IMAGE_PACKET_BYTES;
        if (!rnd_image_send(sender->socket, RND_IMAGE_DATA, (const char *)pixels + at, n, -1)) return false;
    }
    return true;
}

/* The bytes of a file that come in packets. It ends with the socket. The caller frees. */
static void *receive_file(int socket, uint64_t count)
{
    char *file = malloc(count + 1);
    enum rnd_image_packet kind;
    if (!file) _exit(RND_READER_MEMORY);
    for (uint64_t at = 0; at < count;) {
        const ssize_t got = rnd_image_receive(socket, &kind, file + at, count - at, NULL);
        if (got <= 0 || kind != RND_IMAGE_DATA) _exit(0);
        at += (uint64_t)got;
    }
    return file;
}

static void serve(int socket)
{
    struct {
        struct rnd_image_request request;
        char path[RND_IMAGE_MOST_PATH];
    } packet;
    struct sender sender = {.sink = {send_begin, send_rows}, .socket = socket};
    char error[RND_ERROR_SIZE / 2] = "";
    for (;;) {
        enum rnd_image_packet kind;
        const ssize_t got = rnd_image_receive(socket, &kind, &packet, sizeof packet - 1, NULL);
        if (got < (ssize_t)sizeof packet.request || kind != RND_IMAGE_REQUEST) _exit(0);
        packet.path[(size_t)got - sizeof packet.request] = '\0';
        rnd_reader_limit_time(packet.request.seconds);
        void *file = packet.request.in_memory ? receive_file(socket, packet.request.file_bytes) : NULL;
        sender.size_only = packet.request.size_only;
        sender.begun = false;
        const bool whole = rnd_pixels_stream(packet.path, file, packet.request.file_bytes,
                                             (enum rnd_pixels_use)packet.request.use,
                                             packet.request.want_bytes, &sender.sink, error, sizeof error);
        if (whole || (sender.size_only && sender.begun)) {
            rnd_image_send(socket, RND_IMAGE_END, "", 0, -1);
        } else {
            if (strstr(error, "bad_alloc") || strstr(error, "not enough memory")) _exit(RND_READER_MEMORY);
            rnd_image_send(socket, RND_IMAGE_ERROR, error, strlen(error), -1);
        }
        free(file);
        rnd_reader_limit_time(0);
    }
}

/* --- the program itself --- */

struct copies {
    int count;
    pid_t pid[MOST_COPIES];
    int socket[MOST_COPIES]; /* of each, for a last word */
};

static void make_copy(struct copies *copies, int socket, const struct rnd_reader_limits *limits)
{
    const pid_t parent = getpid();
    if (copies->count == MOST_COPIES) {
        close(socket);
        return;
    }
    const pid_t pid = fork();
    if (pid == 0) {
        close(CONTROL);
        for (int i = 0; i < copies->count; i++) close(copies->socket[i]);
        rnd_reader_begin(parent, limits->mib);
        serve(socket);
    }
    if (pid < 0) {
        close(socket);
        return;
    }
    copies->pid[copies->count] = pid;
    copies->socket[copies->count++] = socket;
}

/* Tell of copies that have ended. */
static void bury(struct copies *copies)
{
    int status;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0;)
        for (int i = 0; i < copies->count; i++) {
            if (copies->pid[i] != pid) continue;
            /* one who does not read must not keep all others waiting */
            const struct timeval second = {.tv_sec = 1};
            setsockopt(copies->socket[i], SOL_SOCKET, SO_SNDTIMEO, &second, sizeof second);
            rnd_image_send(copies->socket[i], RND_IMAGE_STATUS, &status, sizeof status, -1);
            close(copies->socket[i]);
            copies->pid[i] = copies->pid[--copies->count];
            copies->socket[i] = copies->socket[copies->count];
            break;
        }
}

static void on_child(int number)
{
    (void)number;
}

int main(void)
{
    static struct copies copies;
    const struct sigaction action = {.sa_handler = on_child};
    struct pollfd control = {.fd = CONTROL, .events = POLLIN};
    sigset_t child, usual;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    sigaction(SIGCHLD, &action, NULL);
    sigprocmask(SIG_BLOCK, &child, &usual);
    for (;;) {
        const int came = ppoll(&control, 1, NULL, &usual);
        bury(&copies);
        if (came <= 0) continue;
        enum rnd_image_packet kind;
        struct rnd_reader_limits limits;
        int socket;
        const ssize_t got = rnd_image_receive(CONTROL, &kind, &limits, sizeof limits, &socket);
        if (got < 0) _exit(0); /* nobody is there any more: copies end with it */
        if (socket < 0) continue;
        sigprocmask(SIG_SETMASK, &usual, NULL);
        make_copy(&copies, socket, &limits);
        sigprocmask(SIG_BLOCK, &child, NULL);
    }
}
