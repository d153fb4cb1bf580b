/* Pictures read by another program, fovead-image-reader. What it sends is not trusted: sizes are checked. If
 * a file ends the program, the error line says so.
 *
 * That program takes long to start, since OpenImageIO has many libraries. So it is started once, reads
 * nothing itself, and makes a copy of itself (fork) for everybody who wants pictures: the copies read. It
 * ends by itself when nobody has asked it for a while. Between it and this program, and between this program
 * and each copy, there is a socket of packets: enum rnd_image_packet, then what it says.
 */
#ifndef FOVEAD_RENDERER_IMAGE_READER_H
#define FOVEAD_RENDERER_IMAGE_READER_H

#include "scene/image_io.h"
#include "import/reader.h"

enum rnd_image_packet {
    RND_IMAGE_COPY,    /* to the program: struct rnd_reader_limits, and the copy's end of a socket */
    RND_IMAGE_REQUEST, /* struct rnd_image_request, then the path; the file's bytes follow, if they are in
                          memory */
    RND_IMAGE_DATA,    /* bytes: of a file, or of rows */
    RND_IMAGE_BEGIN,   /* struct rnd_picture; its rows follow, whole rows from the first to the last */
    RND_IMAGE_END,     /* all rows came; nothing more */
    RND_IMAGE_ERROR,   /* a line, without the path */
    RND_IMAGE_STATUS,  /* from the program, when the copy has ended: its status as of wait() */
};

enum { RND_IMAGE_PACKET_BYTES = 1 << 16, RND_IMAGE_MOST_PATH = 4096 };

struct rnd_image_request {
    uint64_t file_bytes;                                     /* that follow, if they are in memory */
    uint32_t in_memory, use, want_bytes, size_only, seconds; /* size_only: no rows come */
};

/* Send a packet: its kind, count bytes, and a descriptor unless that is negative. False if it cannot be sent;
 * an end that does not wait says EAGAIN. */
bool rnd_image_send(int socket, enum rnd_image_packet kind, const void *bytes, size_t count, int fd);
/* Receive a packet into at most count bytes; *out_fd (may be NULL) is a descriptor that came with it, or -1.
 * Returns how many bytes, -1 on failure (errno), -2 at the end. */
ssize_t rnd_image_receive(int socket, enum rnd_image_packet *out_kind, void *bytes, size_t count,
                          int *out_fd);

/* --- in the program that wants pictures --- */

/* One who wants pictures, one after the other. */
struct rnd_image_reader {
    struct rnd_readers *readers;
    struct rnd_reader_limits limits;
    const atomic_bool *cancel[2]; /* either ends all waiting; each may be NULL */
    int socket;                   /* -1: there is no copy yet, or it has ended */
};

/* As rnd_pixels_stream(), in another process. */
bool rnd_image_read_apart(struct rnd_image_reader *reader, const char *path, const void *memory, size_t count,
                          enum rnd_pixels_use use, bool want_bytes, struct rnd_pixels_sink *sink,
                          char *out_error, size_t error_size);
/* What the picture would begin with. */
bool rnd_image_size_apart(struct rnd_image_reader *reader, const char *path, const void *memory, size_t count,
                          enum rnd_pixels_use use, bool want_bytes, struct rnd_picture *out_picture,
                          char *out_error, size_t error_size);
void rnd_image_reader_finish(struct rnd_image_reader *reader);

#endif
