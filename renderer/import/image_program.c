/* Starting fovead-image, and asking it for copies of itself. */
#include "import/image_program.h"
#include "import/image_packet.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

struct rnd_image_program {
    pthread_mutex_t lock; /* of all that follows */
    int users;
    pid_t pid;   /* 0: it does not run */
    int control; /* -1 if it does not run */
};

struct rnd_image_program *rnd_image_program_create(void)
{
    struct rnd_image_program *program = calloc(1, sizeof *program);
    if (!program) return NULL;
    pthread_mutex_init(&program->lock, NULL);
    program->users = 1;
    program->control = -1;
    return program;
}

struct rnd_image_program *rnd_image_program_share(struct rnd_image_program *program)
{
    pthread_mutex_lock(&program->lock);
    program->users++;
    pthread_mutex_unlock(&program->lock);
    return program;
}

/* Kill the program, which may still be loading its libraries. Its copies end with it. */
static void end(struct rnd_image_program *program)
{
    if (!program->pid) return;
    kill(program->pid, SIGKILL);
    while (waitpid(program->pid, NULL, 0) < 0 && errno == EINTR) continue;
    close(program->control);
    program->pid = 0;
    program->control = -1;
}

void rnd_image_program_destroy(struct rnd_image_program *program)
{
    if (!program) return;
    pthread_mutex_lock(&program->lock);
    const bool last = --program->users == 0;
    pthread_mutex_unlock(&program->lock);
    if (!last) return;
    end(program);
    pthread_mutex_destroy(&program->lock);
    free(program);
}

static bool fail(char out_error[RND_ERROR_SIZE])
{
    snprintf(out_error, RND_ERROR_SIZE, "cannot start fovead-image: %s", strerror(errno));
    return false;
}

static bool start(struct rnd_image_program *program, char out_error[RND_ERROR_SIZE])
{
    static char name[] = "fovead-image";
    int pair[2];
    if (program->pid) return true;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) return fail(out_error);
    program->pid = rnd_reader_start(name, (char *const[]){name, NULL}, &pair[1], 1, out_error);
    close(pair[1]);
    if (program->pid)
        program->control = pair[0];
    else
        close(pair[0]);
    return program->pid != 0;
}

bool rnd_image_program_start(struct rnd_image_program *program, char out_error[RND_ERROR_SIZE])
{
    pthread_mutex_lock(&program->lock);
    const bool started = start(program, out_error);
    pthread_mutex_unlock(&program->lock);
    return started;
}

void rnd_image_program_gone(struct rnd_image_program *program, pid_t pid)
{
    pthread_mutex_lock(&program->lock);
    if (program->pid == pid) end(program);
    pthread_mutex_unlock(&program->lock);
}

int rnd_image_program_copy(struct rnd_image_program *program, const struct rnd_reader_limits *limits,
                           pid_t *out_pid, char out_error[RND_ERROR_SIZE])
{
    int pair[2];
    bool ok = false;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) return fail(out_error), -1;
    pthread_mutex_lock(&program->lock);
    for (int turn = 0; turn < 2 && !ok && start(program, out_error); turn++) {
        ok = rnd_image_send(program->control, RND_IMAGE_COPY, limits, sizeof *limits, pair[1]) ||
             fail(out_error);
        if (!ok) end(program);
    }
    *out_pid = program->pid;
    pthread_mutex_unlock(&program->lock);
    close(pair[1]);
    if (ok && fcntl(pair[0], F_SETFL, O_NONBLOCK) == 0) return pair[0];
    close(pair[0]);
    return -1;
}
