/* A C face for OpenImageIO, which has only a C++ one. import/image_io.cc is the only C++ of the product. */
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

enum { RND_MAX_CHANNELS = 8, RND_MAX_PIXELS = 1 << 30 };

/* Pixels in memory: bytes if the file holds 8-bit integers and bytes were asked for, else floats. One is
 * NULL. Floats of colours are linear light, bytes of colours sRGB; alpha is as it is stored. */
struct rnd_pixels {
    int width, height, channels;
    bool display;   /* the file's colours are encoded for a display: integers that are not marked as linear */
    uint8_t *bytes; /* malloc'ed, width * height * channels */
    float *floats;
    char channel_names[RND_MAX_CHANNELS][32];
};

/* A picture whose rows are to come. */
struct rnd_picture {
    int width, height, channels;
    bool display, bytes; /* as of struct rnd_pixels; rows are bytes, else floats */
    char channel_names[RND_MAX_CHANNELS][32];
};

/* Who takes a picture. Either says false if memory is short. */
struct rnd_pixels_sink {
    bool (*begin)(struct rnd_pixels_sink *sink, const struct rnd_picture *picture);
    /* count rows from the first on, in order; pixels are the caller's. */
    bool (*rows)(struct rnd_pixels_sink *sink, int first, int count, const void *pixels);
};

/* An image file, and what it is read for. */
struct rnd_pixels_file {
    const char *path;
    const void *memory; /* count bytes that are read instead; the path is their name. NULL: none */
    size_t count;
    enum rnd_pixels_use use;
    bool want_bytes; /* if the file holds 8-bit integers */
};

/* Read the first part of an image file, some rows at a time. At most RND_MAX_CHANNELS channels. Error text is
 * one line without the path. */
bool rnd_pixels_stream(const struct rnd_pixels_file *file, struct rnd_pixels_sink *sink, char *out_error,
                       size_t error_size);
/* Read it all into memory. */
bool rnd_pixels_read(const struct rnd_pixels_file *file, struct rnd_pixels *out_pixels, char *out_error,
                     size_t error_size);
void rnd_pixels_finish(struct rnd_pixels *pixels);

/* No wider integers: OpenImageIO takes 0..1 for all of an integer's range, so that counts would not survive.
 */
enum rnd_channel_type { RND_HALF, RND_FLOAT, RND_BYTE };

struct rnd_channel {
    char name[32];
    enum rnd_channel_type type;
};

/* What is written. */
struct rnd_layout {
    int width, height, channels;
    struct rnd_channel channel[RND_MAX_CHANNELS];
    bool equirectangular; /* with the marks by which a viewer knows a 360-degree panorama */
    char format[16];      /* a file name extension */
};

/* Who has the pixels. */
struct rnd_pixels_source {
    /* Fill count rows of interleaved floats from the first on; asked for in order, all of them, or
     * again from the first. */
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
