/* Reading and writing pictures by copies of fovead-image. */
#include "import/image_apart.h"
#include "import/image_packet.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The exchange with a copy about one picture. */
struct talk {
    const char *who; /* what the copy is called in error lines */
    int socket;
    const atomic_bool *cancel[2];
    struct rnd_reader_limits limits;
    double last; /* when patience ends: rnd_reader_now() */
    char *error;
    size_t error_size;
    bool over; /* the copy takes nothing more; its last packets tell why */
    bool gone; /* the copy has ended, and no packet tells how */
};

static bool fail(struct talk *talk, const char *what)
{
    snprintf(talk->error, talk->error_size, "%s", what);
    rnd_make_printable(talk->error);
    return false;
}

static bool fail_with(struct talk *talk, const char *what)
{
    char line[RND_ERROR_SIZE / 2];
    snprintf(line, sizeof line, "%s %s", talk->who, what);
    return fail(talk, line);
}

/* Wait until the socket can be read or written. */
static bool wait_for(struct talk *talk, short events)
{
    enum { LOOK_MS = 50 };
    struct pollfd one = {.fd = talk->socket, .events = events};
    for (;;) {
        for (int i = 0; i < 2; i++)
            if (talk->cancel[i] && atomic_load(talk->cancel[i]))
                return fail(talk, "nobody wants it any more");
        if (rnd_reader_now() > talk->last) return fail_with(talk, "is not done in time");
        if (poll(&one, 1, LOOK_MS) > 0) return true;
    }
}

/* If the copy takes nothing more, nothing is sent; that is no failure, since its answer will tell why. */
static bool send_packet(struct talk *talk, enum rnd_image_packet kind, const void *bytes, size_t count,
                        int fd)
{
    while (!talk->over) {
        if (!wait_for(talk, POLLOUT)) return false;
        if (rnd_image_send(talk->socket, kind, bytes, count, fd)) return true;
        talk->over = errno == EPIPE || errno == ECONNRESET;
        if (!talk->over && errno != EAGAIN) return fail(talk, strerror(errno));
    }
    return true;
}

static bool send_data(struct talk *talk, const void *bytes, size_t count)
{
    for (size_t at = 0, n; at < count && !talk->over; at += n) {
        n = count - at < RND_IMAGE_PACKET_BYTES ? count - at : RND_IMAGE_PACKET_BYTES;
        if (!send_packet(talk, RND_IMAGE_DATA, (const char *)bytes + at, n, -1)) return false;
    }
    return true;
}

/* Receive the next packet. -1 on failure, also if the packet tells that the copy has ended. */
static ssize_t receive_packet(struct talk *talk, enum rnd_image_packet *out_kind, void *bytes, size_t count)
{
    for (;;) {
        ssize_t got;
        int status;
        if (!wait_for(talk, POLLIN)) return -1;
        got = rnd_image_receive(talk->socket, out_kind, bytes, count, NULL);
        /* ECONNRESET comes once, before what the copy sent, if the copy has left something unread */
        if (got == -1 && (errno == EAGAIN || errno == ECONNRESET)) continue;
        talk->gone = got < 0;
        if (talk->gone) return fail_with(talk, "has gone"), -1;
        if (*out_kind != RND_IMAGE_STATUS) return got;
        if (got != sizeof status || count < sizeof status) return fail_with(talk, "has gone"), -1;
        memcpy(&status, bytes, sizeof status);
        char why[120];
        rnd_reader_why(talk->who, status, &talk->limits, why, sizeof why);
        return fail(talk, why), -1;
    }
}

/* Take a line of error that came instead, and put about before it. Returns false. */
static bool take_error(struct talk *talk, const char *about, enum rnd_image_packet kind, const void *text,
                       size_t count)
{
    char line[RND_ERROR_SIZE / 2];
    if (kind != RND_IMAGE_ERROR || count == 0) return fail_with(talk, "has gone");
    snprintf(line, sizeof line, "%s%.*s", about, count < sizeof line ? (int)count : (int)sizeof line,
             (const char *)text);
    return fail(talk, line);
}

/* --- reading --- */

static const char NOT_READABLE[] = "not a readable image: ";

/* One picture that is wanted. */
struct wanted {
    struct talk talk;
    const struct rnd_pixels_file *file;
    struct rnd_pixels_sink *sink; /* NULL: only the size is wanted */
    struct rnd_picture picture;
};

static bool ask(struct wanted *wanted)
{
    char packet[sizeof(struct rnd_image_request) + RND_IMAGE_MOST_PATH];
    const size_t length = strlen(wanted->file->path), count = wanted->file->count;
    const void *memory = wanted->file->memory;
    const struct rnd_image_request request = {.file_bytes = memory ? count : 0,
                                              .in_memory = memory != NULL,
                                              .use = wanted->file->use,
                                              .want_bytes = wanted->file->want_bytes,
                                              .size_only = !wanted->sink,
                                              .seconds = wanted->talk.limits.seconds};
    if (length >= RND_IMAGE_MOST_PATH) return fail(&wanted->talk, strerror(ENAMETOOLONG));
    memcpy(packet, &request, sizeof request);
    memcpy(packet + sizeof request, wanted->file->path, length);
    return send_packet(&wanted->talk, RND_IMAGE_REQUEST, packet, sizeof request + length, -1) &&
           (!memory || send_data(&wanted->talk, memory, count));
}

/* Is it a possible picture? */
static bool is_picture(const struct rnd_picture *picture, bool want_bytes)
{
    return picture->width > 0 && picture->height > 0 &&
           (int64_t)picture->width * picture->height <= RND_MAX_PIXELS && picture->channels > 0 &&
           picture->channels <= RND_MAX_CHANNELS && *(const unsigned char *)&picture->bytes <= want_bytes &&
           *(const unsigned char *)&picture->display <= 1;
}

/* Pass all rows to the sink, some at a time. */
static bool take_rows(struct wanted *wanted, const struct rnd_picture *picture)
{
    enum { STRIP_BYTES = 4 << 20 };
    struct talk *talk = &wanted->talk;
    const size_t row = (size_t)picture->width * (size_t)picture->channels *
                       (picture->bytes ? 1 : sizeof(float)),
                 most = row < STRIP_BYTES ? STRIP_BYTES / row : 1;
    uint8_t *strip = malloc(most * row + RND_IMAGE_PACKET_BYTES);
    size_t have = 0; /* bytes: a packet may end in the next strip */
    bool ok = strip || fail(talk, "not enough memory");
    for (int y = 0, rows; ok && y < picture->height; y += rows) {
        const size_t left = (size_t)(picture->height - y);
        rows = (int)(left < most ? left : most);
        const size_t all = (size_t)rows * row;
        while (ok && have < all) {
            enum rnd_image_packet kind;
            const ssize_t got = receive_packet(talk, &kind, strip + have, RND_IMAGE_PACKET_BYTES);
            if (got > 0 && kind == RND_IMAGE_DATA)
                have += (size_t)got;
            else
                ok = got >= 0 && take_error(talk, NOT_READABLE, kind, strip + have, (size_t)got);
        }
        ok = ok && (wanted->sink->rows(wanted->sink, y, rows, strip) || fail(talk, "not enough memory"));
        if (ok) memmove(strip, strip + all, have -= all);
    }
    ok = ok && (have == 0 || fail_with(talk, "has gone"));
    free(strip);
    return ok;
}

static bool take(struct wanted *wanted)
{
    char text[RND_ERROR_SIZE];
    struct talk *talk = &wanted->talk;
    struct rnd_picture *picture = &wanted->picture;
    enum rnd_image_packet kind;
    _Static_assert(sizeof *picture <= sizeof text, "either comes first");
    ssize_t got = receive_packet(talk, &kind, text, sizeof text - 1);
    if (got >= 0 && kind == RND_IMAGE_BEGIN && got == sizeof *picture) {
        memcpy(picture, text, sizeof *picture);
        if (!is_picture(picture, wanted->file->want_bytes)) return fail(talk, "image size out of range");
        if (wanted->sink && !wanted->sink->begin(wanted->sink, picture))
            return fail(talk, "not enough memory");
        if (wanted->sink && !take_rows(wanted, picture)) return false;
        got = receive_packet(talk, &kind, text, sizeof text - 1);
    }
    if (got < 0) return false;
    return (kind == RND_IMAGE_END && picture->width > 0) ||
           take_error(talk, NOT_READABLE, kind, text, (size_t)got);
}

static bool get(struct rnd_image_reader *reader, struct wanted *wanted, char *out_error, size_t error_size)
{
    const struct rnd_scene_options options = {.reader_mib = reader->limits.mib,
                                              .reader_seconds = reader->limits.seconds};
    const struct rnd_reader_limits limits = rnd_reader_limits(&options, wanted->file->path);
    char error[RND_ERROR_SIZE];
    bool ok = false, again = true;
    for (int turn = 0; turn < 2 && !ok && again; turn++) {
        wanted->talk = (struct talk){.who = "the reader",
                                     .cancel = {reader->cancel[0], reader->cancel[1]},
                                     .limits = limits,
                                     .last = rnd_reader_now() + 2.0 * limits.seconds * RND_READER_PATIENCE,
                                     .error = out_error,
                                     .error_size = error_size};
        if (reader->socket < 0)
            reader->socket = rnd_image_program_copy(reader->program, &reader->limits, &reader->pid, error);
        if (reader->socket < 0) return fail(&wanted->talk, error);
        wanted->talk.socket = reader->socket;
        ok = ask(wanted) && take(wanted);
        if (!ok) rnd_image_reader_finish(reader); /* the state of the copy is unknown */
        /* ask another copy, once; but not if the sink has begun, which cannot begin again */
        again = wanted->talk.gone && wanted->picture.width == 0;
        if (wanted->talk.gone) rnd_image_program_gone(reader->program, reader->pid);
    }
    return ok;
}

bool rnd_image_read_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_pixels_sink *sink, char *out_error, size_t error_size)
{
    struct wanted wanted = {.file = file, .sink = sink};
    return get(reader, &wanted, out_error, error_size);
}

bool rnd_image_size_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_picture *out_picture, char *out_error, size_t error_size)
{
    struct wanted wanted = {.file = file};
    const bool ok = get(reader, &wanted, out_error, error_size);
    *out_picture = wanted.picture;
    return ok;
}

void rnd_image_reader_finish(struct rnd_image_reader *reader)
{
    if (reader->socket >= 0) close(reader->socket);
    reader->socket = -1;
}

/* --- writing --- */

/* Send all rows, each in packets of its own. */
static bool send_rows(struct talk *talk, const struct rnd_layout *layout, struct rnd_pixels_source *source)
{
    const size_t values = (size_t)layout->width * (size_t)layout->channels;
    float *row = malloc(values * sizeof *row);
    bool ok = row || fail(talk, "not enough memory");
    for (int y = 0; ok && y < layout->height && !talk->over; y++) {
        source->rows(source, y, 1, row);
        ok = send_data(talk, row, values * sizeof *row);
    }
    free(row);
    return ok;
}

/* Open the file again, so that its lock (flock) stays with this program alone; if that fails, the same
 * descriptor. */
static int open_again(int fd)
{
    char path[32];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    const int again = open(path, O_WRONLY | O_CLOEXEC);
    return again >= 0 ? again : fcntl(fd, F_DUPFD_CLOEXEC, 0);
}

static bool put(struct talk *talk, const struct rnd_layout *layout, struct rnd_pixels_source *source, int fd)
{
    char text[RND_ERROR_SIZE];
    enum rnd_image_packet kind;
    if (!send_packet(talk, RND_IMAGE_WRITE, layout, sizeof *layout, fd) || !send_rows(talk, layout, source))
        return false;
    const ssize_t got = receive_packet(talk, &kind, text, sizeof text);
    return got >= 0 && (kind == RND_IMAGE_END || take_error(talk, "", kind, text, (size_t)got));
}

bool rnd_image_write_apart(struct rnd_image_program *program, int fd, const struct rnd_layout *layout,
                           struct rnd_pixels_source *source, char *out_error, size_t error_size)
{
    bool ok = false, again = true;
    for (int turn = 0; turn < 2 && !ok && again; turn++) {
        struct talk talk = {
            .who = "the writer", .last = INFINITY, .error = out_error, .error_size = error_size};
        char error[RND_ERROR_SIZE];
        pid_t pid;
        talk.socket = rnd_image_program_copy(program, &talk.limits, &pid, error);
        if (talk.socket < 0) return fail(&talk, error);
        const int own = open_again(fd);
        if (own < 0 || (turn > 0 && ftruncate(fd, 0) != 0))
            fail(&talk, strerror(errno));
        else
            ok = put(&talk, layout, source, own);
        if (own >= 0) close(own);
        close(talk.socket);
        again = talk.gone; /* start another program, once */
        if (again) rnd_image_program_gone(program, pid);
    }
    return ok;
}
