/* Reading a scene file by fovead-reader: starting that program, waiting for it, and taking over what it has
 * read. */
#include "import/read_scene.h"
#include "import/flat_take.h"
#include "import/reader.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

static bool is_cancelled(const struct rnd_scene_options *options)
{
    return options->cancel && atomic_load(options->cancel);
}

/* Wait for a reader to end, when it closes its end of alive. A reader keeps to its limits itself; one that
 * does not is killed here. */
static int wait_for(pid_t pid, int alive, const struct rnd_scene_options *options,
                    const struct rnd_reader_limits *limits)
{
    enum { LOOK_MS = 50 };
    struct pollfd end = {.fd = alive, .events = POLLIN};
    const double last = rnd_reader_now() + 2.0 * limits->seconds * RND_READER_PATIENCE;
    int status = 0;
    while (poll(&end, 1, LOOK_MS) <= 0 && !is_cancelled(options) && rnd_reader_now() <= last) continue;
    kill(pid, SIGKILL); /* if the reader is just ending, this does not change its status, which is set
                           before its descriptors close */
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

/* Take over the scene in memory, once that is sealed against changes. */
static bool take_over(struct rnd_scene *scene, int memory, const char *path, char out_error[RND_ERROR_SIZE])
{
    const int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
    const off_t size = fcntl(memory, F_ADD_SEALS, seals) == 0 ? lseek(memory, 0, SEEK_END) : -1;
    char why[RND_ERROR_SIZE / 2];
    if (size <= 0) {
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
        rnd_reader_why("the reader", status, &limits, why, sizeof why);
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", options->path, why);
    }
end:
    if (alive[0] >= 0) close(alive[0]);
    if (alive[1] >= 0) close(alive[1]);
    if (memory >= 0) close(memory);
    return ok;
}
