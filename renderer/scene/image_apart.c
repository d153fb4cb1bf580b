/* Asking copies of fovead-image for pictures. */
#include "scene/image_apart.h"
#include "scene/image_packet.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* One picture that is wanted. */
struct wanted {
    struct rnd_image_reader *reader;
    struct rnd_reader_limits limits; /* of this file */
    double last;                     /* when patience ends: rnd_reader_now() */
    const char *path;
    const void *memory; /* NULL: it is a file */
    size_t count;       /* bytes of that */
    enum rnd_pixels_use use;
    bool want_bytes;
    struct rnd_pixels_sink *sink; /* NULL: only what it begins with is wanted */
    struct rnd_picture picture;
    char *error;
    size_t error_size;
    bool lost; /* the copy ended before the picture began, and no status came: another one is asked once */
};

static bool fail(struct wanted *wanted, const char *what)
{
    snprintf(wanted->error, wanted->error_size, "%s", what);
    rnd_make_printable(wanted->error);
    return false;
}

/* Wait until the socket can be read or written. */
static bool wait_for(struct wanted *wanted, short events)
{
    enum { LOOK_MS = 50 };
    struct rnd_image_reader *reader = wanted->reader;
    struct pollfd one = {.fd = reader->socket, .events = events};
    for (;;) {
        for (int i = 0; i < 2; i++)
            if (reader->cancel[i] && atomic_load(reader->cancel[i]))
                return fail(wanted, "nobody wants it any more");
        if (rnd_reader_now() > wanted->last) return fail(wanted, "the reader is not done in time");
        if (poll(&one, 1, LOOK_MS) > 0) return true;
    }
}

static bool send_packet(struct wanted *wanted, enum rnd_image_packet kind, const void *bytes, size_t count)
{
    for (;;) {
        if (!wait_for(wanted, POLLOUT)) return false;
        if (rnd_image_send(wanted->reader->socket, kind, bytes, count, -1)) return true;
        if (errno == EPIPE || errno == ECONNRESET) return true; /* its status says why */
        if (errno != EAGAIN) return fail(wanted, strerror(errno));
    }
}

/* The next packet; one that says how the reader ended is a failure. -1 then. */
static ssize_t receive_packet(struct wanted *wanted, enum rnd_image_packet *out_kind, void *bytes,
                              size_t count)
{
    for (;;) {
        ssize_t got;
        int status;
        if (!wait_for(wanted, POLLIN)) return -1;
        got = rnd_image_receive(wanted->reader->socket, out_kind, bytes, count, NULL);
        if (got == -1 && errno == EAGAIN) continue;
        if (got < 0) {
            wanted->lost = wanted->picture.width == 0; /* a sink that has begun cannot begin again */
            return fail(wanted, "the reader has gone"), -1;
        }
        if (*out_kind != RND_IMAGE_STATUS) return got;
        if (got != sizeof status || count < sizeof status) return fail(wanted, "the reader has gone"), -1;
        memcpy(&status, bytes, sizeof status);
        char why[120];
        rnd_reader_why(status, &wanted->limits, why, sizeof why);
        return fail(wanted, why), -1;
    }
}

static bool ask(struct wanted *wanted)
{
    char packet[sizeof(struct rnd_image_request) + RND_IMAGE_MOST_PATH];
    const size_t length = strlen(wanted->path), count = wanted->count;
    const void *memory = wanted->memory;
    const struct rnd_image_request request = {.file_bytes = memory ? count : 0,
                                              .in_memory = memory != NULL,
                                              .use = wanted->use,
                                              .want_bytes = wanted->want_bytes,
                                              .size_only = !wanted->sink,
                                              .seconds = wanted->limits.seconds};
    if (length >= RND_IMAGE_MOST_PATH) return fail(wanted, strerror(ENAMETOOLONG));
    memcpy(packet, &request, sizeof request);
    memcpy(packet + sizeof request, wanted->path, length);
    if (!send_packet(wanted, RND_IMAGE_REQUEST, packet, sizeof request + length)) return false;
    for (size_t at = 0, n; memory && at < count; at += n) {
        n = count - at < RND_IMAGE_PACKET_BYTES ? count - at : RND_IMAGE_PACKET_BYTES;
        if (!send_packet(wanted, RND_IMAGE_DATA, (const char *)memory + at, n)) return false;
    }
    return true;
}

/* Is it a picture that can be? */
static bool is_picture(const struct rnd_picture *picture, bool want_bytes)
{
    return picture->width > 0 && picture->height > 0 &&
           (int64_t)picture->width * picture->height <= RND_MAX_PIXELS && picture->channels > 0 &&
           picture->channels <= RND_MAX_CHANNELS && *(const unsigned char *)&picture->bytes <= want_bytes &&
           *(const unsigned char *)&picture->display <= 1;
}

/* A line in place of what was expected. Returns false. */
static bool take_error(struct wanted *wanted, enum rnd_image_packet kind, const void *text, size_t count)
{
    char line[RND_ERROR_SIZE / 2];
    if (kind != RND_IMAGE_ERROR || count == 0) return fail(wanted, "the reader has gone");
    snprintf(line, sizeof line, "not a readable image: %.*s",
             count < sizeof line ? (int)count : (int)sizeof line, (const char *)text);
    return fail(wanted, line);
}

/* All rows, some at a time, into the sink. */
static bool take_rows(struct wanted *wanted, const struct rnd_picture *picture)
{
    enum { STRIP_BYTES = 4 << 20 };
    const size_t row = (size_t)picture->width * (size_t)picture->channels *
                       (picture->bytes ? 1 : sizeof(float)),
                 most = row < STRIP_BYTES ? STRIP_BYTES / row : 1;
    uint8_t *strip = malloc(most * row + RND_IMAGE_PACKET_BYTES);
    size_t have = 0; /* bytes: a packet may end in the next strip */
    bool ok = strip || fail(wanted, "not enough memory");
    for (int y = 0, rows; ok && y < picture->height; y += rows) {
        const size_t left = (size_t)(picture->height - y);
        rows = (int)(left < most ? left : most);
        const size_t all = (size_t)rows * row;
        while (ok && have < all) {
            enum rnd_image_packet kind;
            const ssize_t got = receive_packet(wanted, &kind, strip + have, RND_IMAGE_PACKET_BYTES);
            if (got > 0 && kind == RND_IMAGE_DATA)
                have += (size_t)got;
            else
                ok = got >= 0 && take_error(wanted, kind, strip + have, (size_t)got);
        }
        ok = ok && (wanted->sink->rows(wanted->sink, y, rows, strip) || fail(wanted, "not enough memory"));
        if (ok) memmove(strip, strip + all, have -= all);
    }
    ok = ok && (have == 0 || fail(wanted, "the reader has gone"));
    free(strip);
    return ok;
}

static bool take(struct wanted *wanted)
{
    char text[RND_ERROR_SIZE];
    struct rnd_picture *picture = &wanted->picture;
    enum rnd_image_packet kind;
    _Static_assert(sizeof *picture <= sizeof text, "either comes first");
    ssize_t got = receive_packet(wanted, &kind, text, sizeof text - 1);
    if (got >= 0 && kind == RND_IMAGE_BEGIN && got == sizeof *picture) {
        memcpy(picture, text, sizeof *picture);
        if (!is_picture(picture, wanted->want_bytes)) return fail(wanted, "image size out of range");
        if (wanted->sink && !wanted->sink->begin(wanted->sink, picture))
            return fail(wanted, "not enough memory");
        if (wanted->sink && !take_rows(wanted, picture)) return false;
        got = receive_packet(wanted, &kind, text, sizeof text - 1);
    }
    if (got < 0) return false;
    return (kind == RND_IMAGE_END && picture->width > 0) || take_error(wanted, kind, text, (size_t)got);
}

static bool get(struct wanted *wanted)
{
    struct rnd_image_reader *reader = wanted->reader;
    const struct rnd_scene_options options = {.reader_mib = reader->limits.mib,
                                              .reader_seconds = reader->limits.seconds};
    char error[RND_ERROR_SIZE];
    bool ok = false;
    wanted->limits = rnd_reader_limits(&options, wanted->path);
    for (int turn = 0; turn < 2 && !ok && (turn == 0 || wanted->lost); turn++) {
        wanted->lost = false;
        wanted->last = rnd_reader_now() + 2.0 * wanted->limits.seconds * RND_READER_PATIENCE;
        if (reader->socket < 0)
            reader->socket = rnd_image_program_copy(reader->program, &reader->limits, error);
        if (reader->socket < 0) return fail(wanted, error);
        ok = ask(wanted) && take(wanted);
        if (!ok) rnd_image_reader_finish(reader); /* nothing is known of what it does now */
    }
    return ok;
}

bool rnd_image_read_apart(struct rnd_image_reader *reader, const char *path, const void *memory, size_t count,
                          enum rnd_pixels_use use, bool want_bytes, struct rnd_pixels_sink *sink,
                          char *out_error, size_t error_size)
{
    struct wanted wanted = {reader,     {0, 0}, 0,   path,      memory,     count, use,
                            want_bytes, sink,   {0}, out_error, error_size, false};
    return get(&wanted);
}

bool rnd_image_size_apart(struct rnd_image_reader *reader, const char *path, const void *memory, size_t count,
                          enum rnd_pixels_use use, bool want_bytes, struct rnd_picture *out_picture,
                          char *out_error, size_t error_size)
{
    struct wanted wanted = {reader,     {0, 0}, 0,   path,      memory,     count, use,
                            want_bytes, NULL,   {0}, out_error, error_size, false};
    const bool ok = get(&wanted);
    *out_picture = wanted.picture;
    return ok;
}

void rnd_image_reader_finish(struct rnd_image_reader *reader)
{
    if (reader->socket >= 0) close(reader->socket);
    reader->socket = -1;
}
