/* Packets between a program and fovead-image, and between the program and copies of fovead-image
 * (image_program.h): a kind, then its content. */
#ifndef FOVEAD_RENDERER_IMAGE_PACKET_H
#define FOVEAD_RENDERER_IMAGE_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

enum rnd_image_packet {
    RND_IMAGE_COPY,    /* to the program: struct rnd_reader_limits, and the copy's end of a socket */
    RND_IMAGE_REQUEST, /* struct rnd_image_request, then the path; the file's bytes follow, if they are in
                          memory */
    RND_IMAGE_WRITE,   /* struct rnd_layout, and a file that is open for writing; the rows of a picture
                         follow, each in packets of its own. It is the last request to a copy. */
    RND_IMAGE_DATA,    /* bytes: of a file, or of rows */
    RND_IMAGE_BEGIN,   /* struct rnd_picture; its rows follow, whole rows from the first to the last */
    RND_IMAGE_END,     /* all rows have been sent, or written */
    RND_IMAGE_ERROR,   /* a line, without the path */
    RND_IMAGE_STATUS,  /* from the program, when the copy has ended: its status as of wait() */
};

enum { RND_IMAGE_PACKET_BYTES = 1 << 16, RND_IMAGE_MOST_PATH = 4096 };

struct rnd_image_request {
    uint64_t file_bytes;                                     /* that follow, if they are in memory */
    uint32_t in_memory, use, want_bytes, size_only, seconds; /* size_only: no rows come */
};

/* Send a packet: its kind, count bytes, and a descriptor unless that is negative. False, with errno, if it
 * cannot be sent; EAGAIN if a non-blocking socket is full. */
bool rnd_image_send(int socket, enum rnd_image_packet kind, const void *bytes, size_t count, int fd);
/* Receive a packet into at most count bytes; *out_fd (may be NULL) is a descriptor that came with it, or -1.
 * Returns how many bytes, -1 on failure (errno), -2 at the end. */
ssize_t rnd_image_receive(int socket, enum rnd_image_packet *out_kind, void *bytes, size_t count,
                          int *out_fd);

#endif
