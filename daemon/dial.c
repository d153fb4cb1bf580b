/* Connects to an address in a thread that nobody waits for: a look-up of a name cannot be cut short. The
 * thread shares nothing with its caller but a pipe, and so does no harm if the caller has gone. */
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "dial.h"
#include "numbers.h"

/* The limit of an attempt. No caller waits for it, and looking up a name alone may take seconds. */
static const uint64_t PATIENCE_NS = 30000000000;

struct attempt {
    struct pro_address address;
    int pipe; /* to write the result to */
};

static void *run(void *argument)
{
    struct attempt *attempt = argument;
    struct dmn_dialled dialled = {.why = ""};

    dialled.fd = pro_dial(&attempt->address, dmn_now_ns() + PATIENCE_NS, false, dialled.why);
    /* SIGPIPE is ignored: see streams.c. */
    if (write(attempt->pipe, &dialled, sizeof(dialled)) != sizeof(dialled) && dialled.fd >= 0)
        close(dialled.fd);
    close(attempt->pipe);
    free(attempt);
    return NULL;
}
_Static_assert(sizeof(struct dmn_dialled) <= PIPE_BUF, "a result is written and read in one piece");

static bool start(const struct pro_address *address, int fd)
{
    struct attempt *attempt = malloc(sizeof(*attempt));
    pthread_attr_t detached;
    pthread_t thread;
    bool good;

    if (!attempt) return false;
    *attempt = (struct attempt){*address, fd};
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    good = !pthread_create(&thread, &detached, run, attempt);
    pthread_attr_destroy(&detached);
    if (!good) free(attempt);
    return good;
}

int dmn_dial(const struct pro_address *address)
{
    int end[2];

    if (pipe2(end, O_CLOEXEC | O_NONBLOCK)) return -1;
    if (start(address, end[1])) return end[0];
    close(end[0]);
    close(end[1]);
    return -1;
}

void dmn_dial_take(int fd, struct dmn_dialled *out_dialled)
{
    if (read(fd, out_dialled, sizeof(*out_dialled)) == sizeof(*out_dialled)) return;
    *out_dialled = (struct dmn_dialled){.fd = -1, .why = "the attempt came to nothing"};
}
