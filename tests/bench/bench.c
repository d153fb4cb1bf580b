/* fovea-bench: measurements, by name. */
#include "bench.h"

#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

static const struct {
    const char *name, *help;
    int (*run)(int count, char **arguments);
} measurement[] = {
    {"converge", "time until the gaze disc reaches a given error, for every distribution", bench_converge},
    {"features", "what each feature of a scene costs, and that it costs nothing where it is absent",
     bench_features},
    {"foveation", "angle between true gaze and what is rendered for; onset of saccades", bench_foveation},
    {"sampling", "error of the renderer's points against that of independent random numbers", bench_sampling},
    {"startup", "time to the first coarse picture, and memory of a film pixel", bench_startup},
    {"throughput", "paths and rays a second, against Embree alone with the same rays", bench_throughput},
};

bool bench_scene_option(int c, struct rnd_scene_options *scene, bool *out_ok)
{
    switch (c) {
    case 's':
        scene->path = optarg;
        return true;
    case 'e':
        scene->env_path = optarg;
        return true;
    case 'u':
        scene->has_sun = *out_ok = sscanf(optarg, "%f,%f,%f,%f", &scene->sun[0], &scene->sun[1],
                                          &scene->sun[2], &scene->sun[3]) == 4;
        return true;
    case 'y':
        scene->has_eye = *out_ok =
            sscanf(optarg, "%f,%f,%f", &scene->eye[0], &scene->eye[1], &scene->eye[2]) == 3;
        return true;
    default:
        return false;
    }
}

void bench_scene_default(struct rnd_scene_options *scene)
{
    if (scene->path) return;
    scene->path = FIXTURES "/hall.gltf";
    if (!scene->env_path) scene->env_path = FIXTURES "/sky.hdr";
}

bool bench_refuse(void)
{
    fprintf(stderr, "fovea-bench: cannot use \"%s\" there\n", optarg);
    return false;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(const double *values, int count)
{
    double sorted[99];
    memcpy(sorted, values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, ascending);
    return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

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
