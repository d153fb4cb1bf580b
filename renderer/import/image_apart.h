/* Pictures read and written by another program, fovead-image (image_program.h). What it sends is not trusted:
 * sizes are checked. If a file ends the program's copy that reads it, the error line says so. */
#ifndef FOVEAD_RENDERER_IMAGE_APART_H
#define FOVEAD_RENDERER_IMAGE_APART_H

#include "import/image_io.h"
#include "import/image_program.h"

/* One who wants pictures, one after the other. */
struct rnd_image_reader {
    struct rnd_image_program *program;
    struct rnd_reader_limits limits;
    const atomic_bool *cancel[2]; /* either ends all waiting; each may be NULL */
    int socket;                   /* -1: there is no copy yet, or it has ended */
    pid_t pid;                    /* of the program that it is a copy of */
};

/* As rnd_pixels_stream(), in another process. */
bool rnd_image_read_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_pixels_sink *sink, char *out_error, size_t error_size);
/* What the picture would begin with. */
bool rnd_image_size_apart(struct rnd_image_reader *reader, const struct rnd_pixels_file *file,
                          struct rnd_picture *out_picture, char *out_error, size_t error_size);
void rnd_image_reader_finish(struct rnd_image_reader *reader);

/* As rnd_pixels_write(), in another process, to a file by its descriptor. Without limits of memory or time:
 * the picture is no stranger's. */
bool rnd_image_write_apart(struct rnd_image_program *program, int fd, const struct rnd_layout *layout,
                           struct rnd_pixels_source *source, char *out_error, size_t error_size);

#endif
