/* The programs that a measurement runs: fovead, with a socket of its own, and children of this program. */
#ifndef FOVEAD_BENCH_PROGRAMS_H
#define FOVEAD_BENCH_PROGRAMS_H

#include <signal.h>
#include <sys/types.h>

#include "daemon.h"

/* fork(); the child ends with this program. Negative after a line on stderr. */
pid_t bench_spawn(void);
/* Send that signal, and wait for the end. Nothing happens if process is not positive. */
void bench_end(pid_t process, int how);

/* What fovead is started with. */
struct bench_fovead {
    const struct rnd_scene_options *scene;
    const char *program; /* NULL: fovead beside this program */
    const char *gaze;
    int width;
};

/* A fovead that runs. All zero: none. */
struct bench_daemon {
    pid_t process;
    struct pro_address address; /* of its socket, in a directory of its own */
    char directory[32];
    uint64_t socket_ns; /* when the socket was there */
};

/* Start fovead, and wait for its socket. False after a line on stderr. In either case bench_daemon_end() is
 * called afterwards: it ends fovead and removes the directory. */
bool bench_daemon_start(struct bench_daemon *daemon, const struct bench_fovead *with);
void bench_daemon_end(struct bench_daemon *daemon);

#endif
