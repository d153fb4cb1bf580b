/* Starting the programs that read files, and telling how they ended. */
#include "import/reader.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_FDS = 4, FIRST_FD = 3, ABOVE_ALL = 16 };

/* The environment without the token, which no reader needs. The caller frees the list. */
static char **environment_of_reader(void)
{
    static const char secret[] = "FOVEAD_TOKEN=";
    size_t count = 0, kept = 0;
    while (environ[count]) count++;
    char **list = malloc((count + 1) * sizeof *list);
    for (size_t i = 0; list && i < count; i++)
        if (strncmp(environ[i], secret, sizeof secret - 1) != 0) list[kept++] = environ[i];
    if (list) list[kept] = NULL;
    return list;
}

/* Silence a reader: libraries print messages about hostile files, and sanitizers report crashes. This program
 * tells how the reader ended. */
static void silence(posix_spawn_file_actions_t *actions)
{
    posix_spawn_file_actions_addopen(actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
}

/* A signal to stop often reaches every program that this one has started, too: a terminal signals its process
 * group, systemd its control group. The reader is still needed then, for the last picture. So it runs in a
 * process group of its own, with these signals blocked from its start. It ends with this program. */
static int spawn(pid_t *out_pid, const char *path, char *const arguments[], const int *fd, int count)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t stop, all;
    char **environment = environment_of_reader();
    if (!environment) return ENOMEM;
    sigemptyset(&stop);
    sigaddset(&stop, SIGINT);
    sigaddset(&stop, SIGTERM);
    sigaddset(&stop, SIGHUP);
    sigfillset(&all);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    silence(&actions);
    for (int i = 0; i < count; i++) posix_spawn_file_actions_adddup2(&actions, fd[i], FIRST_FD + i);
    posix_spawn_file_actions_addclosefrom_np(&actions, FIRST_FD + count);
    posix_spawnattr_setsigmask(&attributes, &stop);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    const int code = posix_spawn(out_pid, path, &actions, &attributes, arguments, environment);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    free(environment);
    return code;
}

pid_t rnd_reader_start(const char *name, char *const arguments[], const int *fd, int count,
                       char out_error[RND_ERROR_SIZE])
{
    char path[4096] = "";
    int high[MOST_FDS] = {-1, -1, -1, -1}, code = 0;
    pid_t pid = 0;
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 64);
    char *slash = length > 0 ? strrchr(path, '/') : NULL;
    strcpy(slash ? slash + 1 : path, name);
    for (int i = 0; i < count; i++) /* so that no descriptor overwrites another */
        if ((high[i] = fcntl(fd[i], F_DUPFD_CLOEXEC, ABOVE_ALL)) < 0) code = errno;
    if (!code) code = spawn(&pid, path, arguments, high, count);
    for (int i = 0; i < count; i++)
        if (high[i] >= 0) close(high[i]);
    if (!code) return pid;
    snprintf(out_error, RND_ERROR_SIZE, "%.300s: %s, expected it beside this program", path, strerror(code));
    return 0;
}

void rnd_reader_why(const char *who, int status, const struct rnd_reader_limits *limits, char *out,
                    size_t size)
{
    const int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
              code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
    const bool full = number == SIGXFSZ || code == RND_READER_MEMORY;
    if (number == SIGXCPU)
        snprintf(out, size, "%s took more than %u s", who, limits->seconds);
    else if (number == SIGALRM)
        snprintf(out, size, "%s was not done after %u s", who, limits->seconds * RND_READER_PATIENCE);
    else if (full && limits->mib > 0)
        snprintf(out, size, "%s took more than %u MiB", who, limits->mib);
    else if (full)
        snprintf(out, size, "not enough memory");
    else if (number)
        snprintf(out, size, "%s crashed (signal %d)", who, number);
    else
        snprintf(out, size, "%s ended with status %d", who, code);
}
