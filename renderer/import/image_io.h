/* A C interface to OpenImageIO, which has only a C++ one. image_io.cc is the only C++ file of the product. */
#ifndef FOVEAD_RENDERER_IMAGE_IO_H
#define FOVEAD_RENDERER_IMAGE_IO_H

#include "scene/pixels.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    RND_MAX_CHANNELS = 8,     /* of a picture that is read */
    RND_LAYOUT_CHANNELS = 20, /* of one that is written */
    RND_MAX_PIXELS = 1 << 30,
};

/* Pixels in memory: bytes if the file holds 8-bit integers and bytes were asked for, else floats. One is
 * NULL. Floats of colours are linear light, bytes of colours sRGB; alpha is as it is stored. */
struct rnd_pixels {
    int width, height, channels;
    bool display;   /* the file's colours are encoded for a display: integers that are not marked as linear */
    uint8_t *bytes; /* malloc'ed, width * height * channels */
    float *floats;
    char channel_names[RND_MAX_CHANNELS][32];
};

/* A picture, before its rows come. */
struct rnd_picture {
    int width, height, channels;
    bool display, bytes; /* display as in struct rnd_pixels; bytes: rows are bytes, else floats */
    char channel_names[RND_MAX_CHANNELS][32];
};

/* Takes a picture. Both functions return false if memory is short. */
struct rnd_pixels_sink {
    bool (*begin)(struct rnd_pixels_sink *sink, const struct rnd_picture *picture);
    /* Take count rows from first on; they come in order. The caller owns pixels. */
    bool (*rows)(struct rnd_pixels_sink *sink, int first, int count, const void *pixels);
};

/* An image file, and what its pixels are used for. */
struct rnd_pixels_file {
    const char *path;
    const void *memory; /* count bytes in memory that are read instead; the path is then their name. NULL:
                           read the file */
    size_t count;
    enum rnd_pixels_use use;
    bool want_bytes;     /* read bytes if the file holds 8-bit integers */
    const char *channel; /* read this one alone; NULL: the first ones */
};

/* Read the first part of an image file, some rows at a time. At most RND_MAX_CHANNELS channels. Error text is
 * one line without the path. */
bool rnd_pixels_stream(const struct rnd_pixels_file *file, struct rnd_pixels_sink *sink, char *out_error,
                       size_t error_size);
/* Read all of the picture into memory. */
bool rnd_pixels_read(const struct rnd_pixels_file *file, struct rnd_pixels *out_pixels, char *out_error,
                     size_t error_size);
void rnd_pixels_finish(struct rnd_pixels *pixels);

/* There are no wider integers: OpenImageIO maps an integer's range to 0..1, so that counts would not survive.
 */
enum rnd_channel_type { RND_HALF, RND_FLOAT, RND_BYTE };

struct rnd_channel {
    char name[32];
    enum rnd_channel_type type;
};

/* The layout of a picture that is written. */
struct rnd_layout {
    int width, height, channels;
    struct rnd_channel channel[RND_LAYOUT_CHANNELS];
    bool equirectangular; /* marked as a 360-degree panorama for viewers */
    char format[16];      /* a file name extension */
};

/* Gives the pixels of a picture. */
struct rnd_pixels_source {
    /* Fill count rows of interleaved floats from first on. All rows are asked for in order, perhaps more than
     * once. */
    void (*rows)(struct rnd_pixels_source *source, int first, int count, float *out_pixels);
};

/* Write a picture, some rows at a time, to a regular file that is open for writing and empty; every channel
 * is stored as its type says (bytes: from 0..1). False if it cannot be encoded, or not all of it written.
 * Error text is one line without the path. */
bool rnd_pixels_write(FILE *file, const struct rnd_layout *layout, struct rnd_pixels_source *source,
                      char *out_error, size_t error_size);

#ifdef __cplusplus
}
#endif
#endif
