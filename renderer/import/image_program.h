/* fovead-image: the program that reads and writes pictures for this one. A file that crashes it does no other
 * harm.
 *
 * It takes long to start, since OpenImageIO has many libraries. So it is started once, and forks a copy of
 * itself for every user; only the copies read and write. It ends with its last user here. Sockets carry
 * packets (image_packet.h) between it and this program, and between each copy and this program. */
#ifndef FOVEAD_RENDERER_IMAGE_PROGRAM_H
#define FOVEAD_RENDERER_IMAGE_PROGRAM_H

#include "import/reader.h"

/* Add a user, who must call rnd_image_program_destroy() in the end. Returns program. */
struct rnd_image_program *rnd_image_program_share(struct rnd_image_program *program);

/* Get a copy of the program, with these limits. If the program has ended, it is started again. Returns the
 * socket to the copy, non-blocking, which the caller closes: the copy ends then. -1 and a line in out_error
 * on failure. *out_pid is the process of the program itself. */
int rnd_image_program_copy(struct rnd_image_program *program, const struct rnd_reader_limits *limits,
                           pid_t *out_pid, char out_error[RND_ERROR_SIZE]);
/* Call this if a copy's socket has ended and no packet told how, so that the program has ended or is about
 * to: wait for that. The next copy is then of a new program. */
void rnd_image_program_gone(struct rnd_image_program *program, pid_t pid);

#endif
