/* fovea-bench: measurements, by name. */
#include "bench.h"
#include "streams.h"

#include <assert.h>
#include <float.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *help;
    int (*run)(int count, char **arguments);
} measurement[] = {
    {"busy", "fovead beside busy loops: first tile, gaps, latencies, paths", bench_busy},
    {"converge", "time until the gaze disc reaches a given error, for every distribution", bench_converge},
    {"features", "what each feature of a scene costs, and that it costs nothing where it is absent",
     bench_features},
    {"foveation", "angle between true gaze and what is rendered for; onset of saccades", bench_foveation},
    {"sampling", "error of the renderer's points against that of independent random numbers", bench_sampling},
    {"startup", "time to the first coarse picture, and memory of a film pixel", bench_startup},
    {"stream", "bytes against sending panoramas, flicker of the periphery, how long tiles take",
     bench_stream},
    {"throughput", "paths and rays per second, against Embree alone with the same rays", bench_throughput},
};

/* --- options --- */

static bool take_number(double value, int i, const struct bench_option *option)
{
    if (!(value >= option->least && value <= option->most)) return false;
    if (option->kind == BENCH_INT && value != floor(value)) return false;
    if (option->kind == BENCH_INT)
        ((int *)option->to)[i] = (int)value;
    else if (option->kind == BENCH_FLOAT)
        ((float *)option->to)[i] = (float)value;
    else
        ((double *)option->to)[i] = value;
    return true;
}

static bool take(const char *text, const struct bench_option *option)
{
    if (option->kind == BENCH_TEXT) {
        *(const char **)option->to = text;
        return true;
    }
    for (int i = 0; i < option->numbers; i++) {
        char *end;
        const double value = strtod(text, &end);
        if (end == text || *end != (i + 1 < option->numbers ? ',' : '\0')) return false;
        if (!take_number(value, i, option)) return false;
        text = end + 1;
    }
    return true;
}

bool bench_options(int count, char **arguments, const char *help, const struct bench_option *list,
                   struct rnd_scene_options *scene, bool *json)
{
    enum { SCENE, ENV, SUN, CAMERA, EYE, SCENE_OPTIONS, MOST = 16 };
    struct bench_option all[MOST];
    struct option option[MOST + 3] = {{"help", no_argument, NULL, 'h'}, {"json", no_argument, NULL, 'j'}};
    int n = 0;
    if (scene) {
        all[SCENE] = (struct bench_option){"scene", BENCH_TEXT, &scene->path, 1, 0, 0};
        all[ENV] = (struct bench_option){"env", BENCH_TEXT, &scene->env_path, 1, 0, 0};
        all[SUN] = (struct bench_option){"sun", BENCH_FLOAT, scene->sun, 4, -FLT_MAX, FLT_MAX};
        all[CAMERA] = (struct bench_option){"camera", BENCH_DOUBLE, scene->camera, 3, -FLT_MAX, FLT_MAX};
        all[EYE] = all[CAMERA];
        all[EYE].name = "eye"; /* the older name */
        n = SCENE_OPTIONS;
    }
    for (; list->name && n < MOST; list++) all[n++] = *list;
    assert(!list->name);
    for (int i = 0; i < n; i++) option[i + 2] = (struct option){all[i].name, required_argument, NULL, 0};
    for (int c, i; (c = getopt_long(count, arguments, "", option, &i)) != -1;) {
        if (c == 'h') {
            fputs(help, stdout);
            exit(0);
        }
        if (c == '?') return false; /* getopt has said why */
        if (c == 'j') {
            *json = true;
            continue;
        }
        if (!take(optarg, &all[i - 2])) {
            fprintf(stderr, "fovea-bench: --%s cannot be \"%s\"\n", option[i].name, optarg);
            return false;
        }
        if (scene && i - 2 == SUN) scene->has_sun = true;
        if (scene && (i - 2 == CAMERA || i - 2 == EYE)) scene->has_camera = true;
    }
    if (optind < count) {
        fprintf(stderr, "fovea-bench: \"%s\" is no option\n", arguments[optind]);
        return false;
    }
    if (scene && !scene->path) {
        scene->path = FIXTURES "/hall.gltf";
        if (!scene->env_path) scene->env_path = FIXTURES "/sky.hdr";
    }
    return true;
}

/* --- figures and charts --- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double bench_median(const double *values, int count)
{
    double sorted[99];
    memcpy(sorted, values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, ascending);
    return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

bool bench_fail(const char *error)
{
    fprintf(stderr, "fovea-bench: %s\n", error);
    return false;
}

int main(int count, char **arguments)
{
    dmn_streams_open("fovea-bench");
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
