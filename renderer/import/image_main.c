/* fovead-image: decodes pictures for a program that does not trust them, and encodes its own; see
 * image_program.h. The program starts it; descriptor 3 is the socket between them. */
#include "import/image_io.h"
#include "import/image_packet.h"
#include "import/reader.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
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

/* Receive the bytes of a file. Ends the process if the socket ends. The caller frees. */
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

/* Does the error say, in the words of the libraries, that memory is short? */
static bool is_short_of_memory(const char *error)
{
    return strstr(error, "bad_alloc") || strstr(error, "not enough memory");
}

static void answer(int socket, bool good, const char *error)
{
    if (!good && is_short_of_memory(error)) _exit(RND_READER_MEMORY);
    rnd_image_send(socket, good ? RND_IMAGE_END : RND_IMAGE_ERROR, error, good ? 0 : strlen(error), -1);
}

static void read_picture(int socket, const struct rnd_image_request *request, const char *path)
{
    struct sender sender = {
        .sink = {send_begin, send_rows}, .socket = socket, .size_only = request->size_only};
    char error[RND_ERROR_SIZE / 2] = "";
    rnd_reader_limit_time(request->seconds);
    void *bytes = request->in_memory ? receive_file(socket, request->file_bytes) : NULL;
    const struct rnd_pixels_file file = {.path = path,
                                         .memory = bytes,
                                         .count = request->file_bytes,
                                         .use = (enum rnd_pixels_use)request->use,
                                         .want_bytes = request->want_bytes};
    const bool whole = rnd_pixels_stream(&file, &sender.sink, error, sizeof error);
    answer(socket, whole || (sender.size_only && sender.begun), error);
    free(bytes);
    rnd_reader_limit_time(0);
}

struct receiver {
    struct rnd_pixels_source source; /* first */
    int socket;
    size_t row; /* bytes */
};

static void receive_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct receiver *receiver = (const struct receiver *)(const void *)source;
    const size_t all = (size_t)count * receiver->row;
    enum rnd_image_packet kind;
    (void)first;
    for (size_t at = 0; at < all;) {
        const ssize_t got =
            rnd_image_receive(receiver->socket, &kind, (char *)out_pixels + at, all - at, NULL);
        if (got <= 0 || kind != RND_IMAGE_DATA) _exit(0);
        at += (size_t)got;
    }
}

static void write_picture(int socket, const struct rnd_layout *layout, int fd)
{
    struct receiver receiver = {
        {receive_rows}, socket, (size_t)layout->width * (size_t)layout->channels * sizeof(float)};
    char error[RND_ERROR_SIZE / 2] = "";
    FILE *file = fdopen(fd, "w");
    if (!file) _exit(RND_READER_MEMORY);
    signal(SIGXFSZ, SIG_IGN); /* a file beyond the limit of its size is an error, as a full disk is */
    answer(socket, rnd_pixels_write(file, layout, &receiver.source, error, sizeof error), error);
    _exit(0);
}

static void serve(int socket)
{
    union {
        struct {
            struct rnd_image_request request;
            char path[RND_IMAGE_MOST_PATH];
        } read;
        struct rnd_layout write;
    } packet;
    for (;;) {
        enum rnd_image_packet kind;
        int fd;
        const ssize_t got = rnd_image_receive(socket, &kind, &packet, sizeof packet - 1, &fd);
        if (got == sizeof packet.write && kind == RND_IMAGE_WRITE && fd >= 0)
            write_picture(socket, &packet.write, fd);
        if (got < (ssize_t)sizeof packet.read.request || kind != RND_IMAGE_REQUEST) _exit(0);
        packet.read.path[(size_t)got - sizeof packet.read.request] = '\0';
        read_picture(socket, &packet.read.request, packet.read.path);
    }
}

/* --- the program itself --- */

struct copies {
    int count;
    pid_t pid[MOST_COPIES];
    int socket[MOST_COPIES]; /* of each, for RND_IMAGE_STATUS */
};

static int child_fd; /* readable when a copy has ended */

static void make_copy(struct copies *copies, int socket, const struct rnd_reader_limits *limits)
{
    const pid_t parent = getpid(), pid = copies->count < MOST_COPIES ? fork() : -1;
    if (pid == 0) {
        close(CONTROL);
        close(child_fd);
        for (int i = 0; i < copies->count; i++) close(copies->socket[i]);
        rnd_reader_begin(parent, limits->mib);
        serve(socket);
    }
    if (pid < 0) {
        static const char why[] = "too many pictures at a time";
        rnd_image_send(socket, RND_IMAGE_ERROR, why, strlen(why), -1);
        close(socket);
        return;
    }
    copies->pid[copies->count] = pid;
    copies->socket[copies->count++] = socket;
}

/* Send the status of copies that have ended. */
static void bury(struct copies *copies)
{
    int status;
    for (pid_t pid; (pid = waitpid(-1, &status, WNOHANG)) > 0;)
        for (int i = 0; i < copies->count; i++) {
            if (copies->pid[i] != pid) continue;
            /* a program that does not read must not make the others wait */
            const struct timeval second = {.tv_sec = 1};
            setsockopt(copies->socket[i], SOL_SOCKET, SO_SNDTIMEO, &second, sizeof second);
            rnd_image_send(copies->socket[i], RND_IMAGE_STATUS, &status, sizeof status, -1);
            close(copies->socket[i]);
            copies->pid[i] = copies->pid[--copies->count];
            copies->socket[i] = copies->socket[copies->count];
            break;
        }
}

/* Any thread may receive the signal, since libraries have started threads before main(): so a waiting call of
 * the main thread need not return. */
static void on_child(int number)
{
    const int error = errno;
    (void)number;
    (void)!eventfd_write(child_fd, 1);
    errno = error;
}

int main(void)
{
    static struct copies copies;
    const struct sigaction action = {.sa_handler = on_child, .sa_flags = SA_RESTART | SA_NOCLDSTOP};
    struct pollfd event[2] = {{.fd = CONTROL, .events = POLLIN}, {.events = POLLIN}};
    child_fd = event[1].fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    sigaction(SIGCHLD, &action, NULL);
    for (;;) {
        eventfd_t ended;
        if (poll(event, 2, -1) < 0) continue;
        if (eventfd_read(child_fd, &ended) == 0) bury(&copies);
        if (!event[0].revents) continue;
        enum rnd_image_packet kind;
        struct rnd_reader_limits limits;
        int socket;
        const ssize_t got = rnd_image_receive(CONTROL, &kind, &limits, sizeof limits, &socket);
        if (got < 0) _exit(0); /* the program has ended; the copies end with this process */
        if (socket >= 0) make_copy(&copies, socket, &limits);
    }
}
