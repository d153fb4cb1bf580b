/* Reading and writing pictures by another program, fovead-image (image_program.h). What it sends is not
 * trusted: sizes are checked. If a file crashes the copy that reads it, the error line says so. */
#ifndef FOVEAD_RENDERER_IMAGE_APART_H
#define FOVEAD_RENDERER_IMAGE_APART_H

#include "import/image_io.h"
#include "import/image_program.h"

/* A reader of pictures, one after the other. */
struct rnd_image_reader {
    struct rnd_image_program *program;
    struct rnd_reader_limits limits;
    const atomic_bool *cancel[2]; /* each ends all waiting when it is set; each may be NULL */
    int socket;                   /* -1: there is no copy yet, or it has ended */
    pid_t pid;                    /* of the program that the copy was made of */
};

/* As rnd_pixels_stream(), in another process. */
bool rnd_image_read_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_pixels_sink *sink, char *out_error, size_t error_size);
/* Read only the picture's size and channels. */
bool rnd_image_size_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_picture *out_picture, char *out_error, size_t error_size);
void rnd_image_reader_finish(struct rnd_image_reader *reader);

/* As rnd_pixels_write(), in another process, to a file by its descriptor. There is no limit of memory or
 * time, as the picture is our own. */
bool rnd_image_write_apart(struct rnd_image_program *program, int fd, const struct rnd_layout *layout,
                           struct rnd_pixels_source *source, char *out_error, size_t error_size);

#endif
