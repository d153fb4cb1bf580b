/* fovea-bench: measurements, by name. */
#include "bench.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>

static const struct {
    const char *name, *help;
    int (*run)(int count, char **arguments);
} measurement[] = {
    {"converge", "time until the gaze disc reaches a given error, for every distribution", bench_converge},
    {"foveation", "angle between true gaze and what is rendered for; onset of saccades", bench_foveation},
};

FILE *bench_draw(void)
{
    signal(SIGPIPE, SIG_IGN); /* it may not be there */
    return popen("gnuplot >/dev/null 2>&1", "w");
}

bool bench_drawn(FILE *gnuplot, const char *path)
{
    const int status = gnuplot ? pclose(gnuplot) : -1;
    if (status == 0) return true;
    if (status > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 127) /* the shell's word for it */
        fprintf(stderr, "fovea-bench: gnuplot is missing: apt-get install gnuplot-nox\n");
    else
        fprintf(stderr, "fovea-bench: %s: gnuplot could not draw it there\n", path);
    return false;
}

int main(int count, char **arguments)
{
    const size_t all = sizeof measurement / sizeof *measurement;
    const char *name = count > 1 ? arguments[1] : "";
    for (size_t i = 0; i < all; i++)
        if (strcmp(name, measurement[i].name) == 0) return measurement[i].run(count - 1, arguments + 1);
    const int asked = strcmp(name, "--help") == 0;
    FILE *to = asked ? stdout : stderr;
    if (!asked) fprintf(to, "fovea-bench: expected the name of a measurement\n");
    fprintf(to, "usage: fovea-bench MEASUREMENT [OPTION...] (MEASUREMENT --help tells its options)\n");
    for (size_t i = 0; i < all; i++) fprintf(to, "  %-10s %s\n", measurement[i].name, measurement[i].help);
    return asked ? 0 : 2;
}
