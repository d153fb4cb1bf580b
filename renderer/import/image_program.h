/* fovead-image: the program that reads and writes pictures for this one, in processes that a file may crash.
 *
 * It takes long to start, since OpenImageIO has many libraries. So it is started once, reads and writes
 * nothing itself, and makes a copy of itself (fork) for everybody who wants to: the copies do. It ends with
 * its last user here. Between it and this program, and between this program and each copy, there is a socket
 * of packets (image_packet.h). */
#ifndef FOVEAD_RENDERER_IMAGE_PROGRAM_H
#define FOVEAD_RENDERER_IMAGE_PROGRAM_H

#include "import/reader.h"

/* One more user, who calls rnd_image_program_destroy() in the end. Returns program. */
struct rnd_image_program *rnd_image_program_share(struct rnd_image_program *program);

/* Get a copy of the program, with these limits; if the program has ended, it is started once more. Returns
 * the socket to the copy, which does not block and is the caller's: the copy ends when it is closed. -1 and a
 * line in out_error on failure. *out_pid is the program's own process. */
int rnd_image_program_copy(struct rnd_image_program *program, const struct rnd_reader_limits *limits,
                           pid_t *out_pid, char out_error[RND_ERROR_SIZE]);
/* A copy's socket has ended and the program has not told how: so the program, by its process, has ended or is
 * about to. Wait for that; the next copy is another one's. */
void rnd_image_program_gone(struct rnd_image_program *program, pid_t pid);

#endif
