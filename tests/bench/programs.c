/* The programs that a measurement runs. */
#include "programs.h"

#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_WORDS = 32 };

pid_t bench_spawn(void)
{
    const pid_t child = fork();
    if (child == 0) prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (child < 0) perror("fovea-bench");
    return child;
}

void bench_end(pid_t process, int how)
{
    if (process <= 0) return;
    kill(process, how);
    waitpid(process, NULL, 0);
}

/* fovead's command line; numbers are printed to text. */
static void words_of(const struct bench_fovead *with, const char *fovead, const char *socket,
                     char text[3][128], const char *word[MOST_WORDS])
{
    const struct rnd_scene_options *scene = with->scene;
    int n = 0;
    word[n++] = fovead;
    word[n++] = "--scene";
    word[n++] = scene->path;
    if (scene->env_path) word[n++] = "--env", word[n++] = scene->env_path;
    snprintf(text[0], sizeof *text, "%.9g,%.9g,%.9g,%.9g", (double)scene->sun[0], (double)scene->sun[1],
             (double)scene->sun[2], (double)scene->sun[3]);
    if (scene->has_sun) word[n++] = "--sun", word[n++] = text[0];
    snprintf(text[1], sizeof *text, "%.9g,%.9g,%.9g", (double)scene->camera[0], (double)scene->camera[1],
             (double)scene->camera[2]);
    if (scene->has_camera) word[n++] = "--camera", word[n++] = text[1];
    snprintf(text[2], sizeof *text, "%d", with->width);
    word[n++] = "--size", word[n++] = text[2];
    word[n++] = "--gaze", word[n++] = with->gaze;
    word[n++] = "--listen", word[n++] = socket;
    word[n] = NULL;
}

bool bench_daemon_start(struct bench_daemon *daemon, const struct bench_fovead *with)
{
    char beside[4096], text[3][128], socket[sizeof daemon->address.path + 8];
    const char *fovead = with->program, *word[MOST_WORDS];
    const ssize_t length = readlink("/proc/self/exe", beside, sizeof beside - 16);
    *daemon = (struct bench_daemon){.address.is_unix = true, .directory = "/tmp/fovea-bench-XXXXXX"};
    if (!mkdtemp(daemon->directory)) {
        perror(daemon->directory);
        daemon->directory[0] = '\0';
        return false;
    }
    snprintf(daemon->address.path, sizeof daemon->address.path, "%s/socket", daemon->directory);
    if (!fovead && length > 0) {
        beside[length] = '\0';
        strcpy(strrchr(beside, '/'), "/fovead");
        fovead = beside;
    }
    pro_address_print(&daemon->address, socket, sizeof socket);
    words_of(with, fovead ? fovead : "fovead", socket, text, word);
    daemon->process = bench_spawn();
    if (daemon->process == 0) {
        if (freopen("/dev/null", "w", stdout)) execvp(word[0], (char **)word);
        perror(word[0]);
        _exit(127);
    }
    while (daemon->process > 0 && access(daemon->address.path, F_OK) != 0) {
        if (waitpid(daemon->process, NULL, WNOHANG) == daemon->process) {
            daemon->process = -1;
            fprintf(stderr, "fovea-bench: %s has ended without a socket\n", word[0]);
        }
        usleep(1000);
    }
    daemon->socket_ns = dmn_now_ns();
    return daemon->process > 0;
}

void bench_daemon_end(struct bench_daemon *daemon)
{
    bench_end(daemon->process, SIGTERM);
    if (daemon->address.path[0]) unlink(daemon->address.path);
    if (daemon->directory[0]) rmdir(daemon->directory);
    *daemon = (struct bench_daemon){0};
}
