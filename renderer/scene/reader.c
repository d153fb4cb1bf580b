/* Starting the programs that read files, and what they hand over. */
#include "scene/flat.h"
#include "scene/reader.h"
#include "scene/scene.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* --- starting --- */

enum { MOST_FDS = 4, FIRST_FD = 3, ABOVE_ALL = 16 };

/* The environment but for the token, which no reader needs. The caller frees the list. */
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

/* What a library says of a hostile file does not go to the terminal; what a sanitizer says does. */
static void silence(posix_spawn_file_actions_t *actions)
{
    posix_spawn_file_actions_addopen(actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    posix_spawn_file_actions_addopen(actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
#endif
}

/* In a process group of its own, so that it is not told to stop by the terminal before this program is. */
static int spawn(pid_t *out_pid, const char *path, char *const arguments[], const int *fd, int count)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, all;
    char **environment = environment_of_reader();
    if (!environment) return ENOMEM;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    silence(&actions);
    for (int i = 0; i < count; i++) posix_spawn_file_actions_adddup2(&actions, fd[i], FIRST_FD + i);
    posix_spawn_file_actions_addclosefrom_np(&actions, FIRST_FD + count);
    posix_spawnattr_setsigmask(&attributes, &none);
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
    for (int i = 0; i < count; i++) /* so that none is overwritten by another */
        if ((high[i] = fcntl(fd[i], F_DUPFD_CLOEXEC, ABOVE_ALL)) < 0) code = errno;
    if (!code) code = spawn(&pid, path, arguments, high, count);
    for (int i = 0; i < count; i++)
        if (high[i] >= 0) close(high[i]);
    if (!code) return pid;
    snprintf(out_error, RND_ERROR_SIZE, "%.300s: %s, expected it beside this program", path, strerror(code));
    return 0;
}

void rnd_reader_why(int status, const struct rnd_reader_limits *limits, char *out, size_t size)
{
    const int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
              code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
    if (number == SIGXCPU)
        snprintf(out, size, "the reader took more than %u s", limits->seconds);
    else if (number == SIGALRM)
        snprintf(out, size, "the reader was not done after %u s", limits->seconds * RND_READER_PATIENCE);
    else if (number == SIGXFSZ || code == RND_READER_MEMORY)
        snprintf(out, size, "the reader took more than %u MiB", limits->mib);
    else if (number)
        snprintf(out, size, "the reader crashed (signal %d)", number);
    else
        snprintf(out, size, "the reader ended with status %d", code);
}

/* --- a scene --- */

static bool is_cancelled(const struct rnd_scene_options *options)
{
    return options->cancel && atomic_load(options->cancel);
}

/* Wait for the end of a reader: nobody has the other end of alive then. It keeps its limits itself; this is
 * for one that does not. */
static int wait_for(pid_t pid, int alive, const struct rnd_scene_options *options,
                    const struct rnd_reader_limits *limits)
{
    enum { LOOK_MS = 50 };
    struct pollfd end = {.fd = alive, .events = POLLIN};
    const time_t last = time(NULL) + 2 * (time_t)limits->seconds * RND_READER_PATIENCE;
    int status = 0;
    while (poll(&end, 1, LOOK_MS) == 0 && !is_cancelled(options) && time(NULL) <= last) continue;
    if (!end.revents) kill(pid, SIGKILL);
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
    return status;
}

/* The line that a reader has left in place of a scene. */
static void take_line(int memory, const char *path, char out_error[RND_ERROR_SIZE])
{
    const ssize_t length = pread(memory, out_error, RND_ERROR_SIZE - 1, 0);
    out_error[length > 0 ? length : 0] = '\0';
    if (!*out_error) snprintf(out_error, RND_ERROR_SIZE, "%.200s: the reader says nothing", path);
    rnd_make_printable(out_error);
}

/* Take over what is in memory, once nobody can change it any more. */
static bool take_over(struct rnd_scene *scene, int memory, const char *path, char out_error[RND_ERROR_SIZE])
{
    const int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
    const off_t size = lseek(memory, 0, SEEK_END);
    char why[RND_ERROR_SIZE / 2];
    if (size <= 0 || fcntl(memory, F_ADD_SEALS, seals) != 0) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: the reader handed nothing over that can be used", path);
        return false;
    }
    scene->flat = mmap(NULL, (size_t)size, PROT_READ, MAP_PRIVATE, memory, 0);
    if (scene->flat == MAP_FAILED) {
        scene->flat = NULL;
        snprintf(out_error, RND_ERROR_SIZE, "not enough memory");
        return false;
    }
    scene->flat_bytes = (size_t)size;
    if (rnd_flat_take(scene, why, sizeof why)) return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: the reader handed over %.200s", path, why);
    return false;
}

bool rnd_scene_read(struct rnd_scene *scene, const struct rnd_scene_options *options,
                    char out_error[RND_ERROR_SIZE])
{
    const struct rnd_reader_limits limits = rnd_reader_limits(options, options->path);
    char number[3][24], why[RND_ERROR_SIZE / 2];
    char *const arguments[] = {
        "fovead-reader", number[0], number[1], number[2], (char *)(uintptr_t)options->path, NULL};
    int memory = memfd_create("scene", MFD_CLOEXEC | MFD_ALLOW_SEALING), alive[2] = {-1, -1};
    bool ok = false;
    snprintf(number[0], sizeof number[0], "%ld", (long)getpid());
    snprintf(number[1], sizeof number[1], "%u", limits.mib);
    snprintf(number[2], sizeof number[2], "%u", limits.seconds);
    if (memory < 0 || pipe2(alive, O_CLOEXEC) != 0) {
        snprintf(out_error, RND_ERROR_SIZE, "cannot start a reader: %s", strerror(errno));
        goto end;
    }
    const pid_t pid =
        rnd_reader_start(arguments[0], arguments, (const int[]){memory, alive[1]}, 2, out_error);
    close(alive[1]);
    alive[1] = -1;
    if (!pid) goto end;
    const int status = wait_for(pid, alive[0], options, &limits);
    if (is_cancelled(options)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: nobody wants it any more", options->path);
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        ok = take_over(scene, memory, options->path, out_error);
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == RND_READER_REFUSES) {
        take_line(memory, options->path, out_error);
    } else {
        rnd_reader_why(status, &limits, why, sizeof why);
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", options->path, why);
    }
end:
    if (alive[0] >= 0) close(alive[0]);
    if (alive[1] >= 0) close(alive[1]);
    if (memory >= 0) close(memory);
    return ok;
}
