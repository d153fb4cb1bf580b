/* Speed against accuracy: how the error of the gaze disc falls with time, for every distribution of samples.
 *
 * All distributions render the same scene in the same run. They take turns of growing length, so that a
 * machine that slows down slows all of them. The error is measured against a reference whose paths all fall
 * around the disc and use other random numbers. Only the time of batches counts. */
#include "bench.h"
#include "chart.h"
#include "renderer.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_POINTS = 256, MAX_WAYS = 16, MAX_REPEATS = 31, BATCH = 4096 };

#define DISC_DEG 5.79f
#define RAD(deg) ((deg) * (float)M_PI / 180.0f)

struct setup {
    struct rnd_scene_options scene;
    float gaze_deg[2]; /* azimuth, elevation */
    int width, bounces, repeats, reference_spp;
    double target, limit_seconds;
    float *disc; /* weight of each pixel of the film: 1 in the gaze disc, else 0 */
    bool json;
    const char *plot;
};

/* The render of one distribution, and its curve of error over time. */
struct way {
    const struct rnd_distribution *distribution;
    struct rnd_render *render;
    double seconds, rays;
    uint64_t paths;
    int points;
    double time[MAX_POINTS], error[MAX_POINTS];
    double reached[MAX_REPEATS]; /* seconds until the target was reached, or INFINITY */
    double paths_per_second[MAX_REPEATS];
    double disc_share; /* share of paths that fell into the disc */
};

static const char help[] =
    "usage: fovea-bench converge [OPTION...]\n"
    "Time until the gaze disc (5.79 degrees) reaches a relative RMSE, for every distribution, in one "
    "run.\n" BENCH_SCENE_HELP
    "  --gaze A,E         azimuth (right) and elevation of the gaze, deg; default 30,-10\n"
    "  --width N          of the film, pixels; default 1024 (the ratios do not depend on it)\n"
    "  --bounces N        default: Russian roulette alone\n"
    "  --target X         relative RMSE; default 0.5\n"
    "  --repeats N        seeds; medians are printed; default 3\n"
    "  --limit S          give up on a distribution after S seconds; default 600\n"
    "  --reference N      paths per pixel of the reference in the disc; default 2000\n"
    "  --plot FILE.svg    error against time, drawn by gnuplot\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"gaze", BENCH_FLOAT, out->gaze_deg, 2, -360, 360},
        {"width", BENCH_INT, &out->width, 1, 1, INT_MAX},
        {"bounces", BENCH_INT, &out->bounces, 1, 0, INT_MAX},
        {"target", BENCH_DOUBLE, &out->target, 1, 1e-6, 1e6},
        {"repeats", BENCH_INT, &out->repeats, 1, 1, MAX_REPEATS},
        {"limit", BENCH_DOUBLE, &out->limit_seconds, 1, 0, 1e9},
        {"reference", BENCH_INT, &out->reference_spp, 1, 1, INT_MAX},
        {"plot", BENCH_TEXT, &out->plot, 1, 0, 0},
        {0},
    };
    *out = (struct setup){.gaze_deg = {30, -10},
                          .width = 1024,
                          .repeats = 3,
                          .reference_spp = 2000,
                          .target = 0.5,
                          .limit_seconds = 600};
    return bench_options(count, arguments, help, option, &out->scene, &out->json);
}

/* Aim at the gaze, with a viewport of this field of view around it. */
static struct rnd_aim aim_at(const struct setup *setup, float fov)
{
    struct rnd_aim aim = {.fov = {fov, fov}};
    const float a = -0.5f * RAD(setup->gaze_deg[0]), e = 0.5f * RAD(setup->gaze_deg[1]);
    rnd_direction(2.0f * -a, 2.0f * e, aim.gaze);
    /* yaw about Y, then pitch about the view's X */
    aim.view[0] = cosf(a) * sinf(e);
    aim.view[1] = sinf(a) * cosf(e);
    aim.view[2] = -sinf(a) * sinf(e);
    aim.view[3] = cosf(a) * cosf(e);
    return aim;
}

static struct rnd_render *create(const struct rnd_scene *scene, const struct setup *setup,
                                 const struct rnd_distribution *distribution, uint64_t seed)
{
    char error[RND_ERROR_SIZE];
    const struct rnd_render_options options = {.width = setup->width,
                                               .height = setup->width / 2,
                                               .seed = seed,
                                               .max_bounces = setup->bounces,
                                               .distribution = distribution};
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fprintf(stderr, "fovea-bench: %s\n", error);
    return render;
}

/* Make the reference of the disc: all paths fall into a viewport that is slightly larger. Returns the film,
 * and the relative standard error in the disc from the half-buffers. */
static float *make_reference(const struct rnd_scene *scene, const struct setup *setup, double *out_error)
{
    const struct rnd_aim aim = aim_at(setup, RAD(2.0f * DISC_DEG + 1.0f));
    struct rnd_render *render = create(scene, setup, rnd_distribution_find("vp"), 0x5eed);
    const size_t pixels = (size_t)setup->width * setup->width / 2;
    float *film = malloc(pixels * 3 * sizeof *film), *error = malloc(pixels * sizeof *error);
    if (!render || !film || !error) exit(1);
    const double area =
        pow(setup->width / 360.0 * (2.0 * DISC_DEG + 1.0), 2.0) / cos(RAD(setup->gaze_deg[1]));
    const uint64_t paths = (uint64_t)(area * setup->reference_spp);
    struct rnd_batch batch;
    for (uint64_t done = 0; done < paths; done += BATCH) {
        rnd_render_batch(render, &aim, 0, BATCH, &batch);
        if (done / BATCH % 128 == 0)
            fprintf(stderr, "\rreference %3.0f %%", 100.0 * (double)done / (double)paths);
    }
    fprintf(stderr, "\r               \r");
    rnd_render_resolve(render, film, NULL, error);
    double square = 0.0, light = 0.0;
    int n = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (setup->disc[i] == 0.0f) continue;
        square += (double)error[i] * error[i];
        light += 0.2126 * film[3 * i] + 0.7152 * film[3 * i + 1] + 0.0722 * film[3 * i + 2];
        n++;
    }
    *out_error = sqrt(square / n) / (light / n);
    rnd_render_destroy(render);
    free(error);
    return film;
}

/* When the curve reached the target, s. Interpolated linearly in log-log, because the error falls with a
 * power of time. */
static double crossing(const struct way *way, double target)
{
    for (int i = 1; i < way->points; i++) {
        if (way->error[i] > target) continue;
        const double t = log(way->error[i - 1] / target) / log(way->error[i - 1] / way->error[i]);
        return way->time[i - 1] * pow(way->time[i] / way->time[i - 1], t);
    }
    return INFINITY;
}

static void measure(struct way *way, const struct setup *setup, const float *reference, float *film)
{
    const struct rnd_pair pair = {.reference = reference,
                                  .test = film,
                                  .width = setup->width,
                                  .height = setup->width / 2,
                                  .panorama = true,
                                  .weight = setup->disc};
    struct rnd_measure measure;
    char error[RND_ERROR_SIZE];
    rnd_render_resolve(way->render, film, NULL, NULL);
    if (!rnd_measure(rnd_metric_find("relative_rmse"), &pair, NULL, &measure, error)) {
        fprintf(stderr, "fovea-bench: %s\n", error);
        exit(1);
    }
    way->time[way->points] = way->seconds;
    way->error[way->points++] = measure.value;
}

static double share_in_disc(struct way *way, const struct setup *setup, float *samples)
{
    double inside = 0.0;
    rnd_render_resolve(way->render, NULL, samples, NULL);
    for (size_t i = 0; i < (size_t)setup->width * (size_t)setup->width / 2; i++)
        inside += (double)setup->disc[i] * samples[i];
    return inside / (double)way->paths;
}

/* One race of all distributions from empty films, with one seed for the random numbers. */
static bool race(const struct rnd_scene *scene, const struct setup *setup, struct way *ways, int count,
                 int repeat, const float *reference, float *film)
{
    const struct rnd_aim aim = aim_at(setup, RAD(100.0f));
    for (int i = 0; i < count; i++) {
        struct way *way = &ways[i];
        way->seconds = way->rays = 0.0;
        way->paths = 0;
        way->points = 0;
        if (!(way->render = create(scene, setup, way->distribution, 1 + (uint64_t)repeat))) return false;
    }
    int running = count;
    for (double until = 0.02; running > 0; until *= 1.2) {
        running = 0;
        for (int i = 0; i < count; i++) {
            struct way *way = &ways[i];
            const bool done = way->points > 1 && way->error[way->points - 1] <= 0.8 * setup->target;
            if (done || way->points == MAX_POINTS || way->seconds > setup->limit_seconds) continue;
            struct rnd_batch batch;
            while (way->seconds < until) {
                const double start = bench_seconds(CLOCK_MONOTONIC);
                rnd_render_batch(way->render, &aim, 0, BATCH, &batch);
                way->seconds += bench_seconds(CLOCK_MONOTONIC) - start; /* includes the survey of lights */
                way->paths += batch.paths;
                way->rays += (double)batch.rays;
            }
            measure(way, setup, reference, film);
            running++;
        }
        fprintf(stderr, "\rseed %d of %d, %d distributions under way, %.1f s each   ", repeat + 1,
                setup->repeats, running, until);
    }
    for (int i = 0; i < count; i++) {
        ways[i].reached[repeat] = crossing(&ways[i], setup->target);
        ways[i].paths_per_second[repeat] = (double)ways[i].paths / ways[i].seconds;
        ways[i].disc_share = share_in_disc(&ways[i], setup, film);
        rnd_render_destroy(ways[i].render);
    }
    return true;
}

static void print_json(const struct setup *setup, const struct way *ways, int count, double reference_error)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        const struct way *way = &ways[i];
        const double seconds = bench_median(way->reached, setup->repeats),
                     first = bench_median(ways[0].reached, setup->repeats);
        json_t *curve = json_array();
        for (int k = 0; k < way->points; k++)
            json_array_append_new(curve, json_pack("[f,f]", way->time[k], way->error[k]));
        json_t *row = json_pack("{s:s,s:f,s:f,s:o}", "distribution", way->distribution->name,
                                "paths_per_second", bench_median(way->paths_per_second, setup->repeats),
                                "disc_share", way->disc_share, "curve", curve);
        json_object_set_new(row, "seconds", isfinite(seconds) ? json_real(seconds) : json_null());
        json_object_set_new(row, "times_slower_than_fv",
                            isfinite(seconds / first) ? json_real(seconds / first) : json_null());
        json_array_append_new(list, row);
    }
    json_t *root = json_pack("{s:s,s:f,s:f,s:f,s:i,s:i,s:f,s:o}", "scene", setup->scene.path, "target",
                             setup->target, "azimuth_deg", setup->gaze_deg[0], "elevation_deg",
                             setup->gaze_deg[1], "width", setup->width, "repeats", setup->repeats,
                             "reference_relative_error", reference_error, "distributions", list);
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

static void print_table(const struct setup *setup, const struct way *ways, int count, double reference_error)
{
    printf("%s, gaze %g right %g up, film %d x %d, medians of %d; error of the reference itself %.3f\n",
           setup->scene.path, setup->gaze_deg[0], setup->gaze_deg[1], setup->width, setup->width / 2,
           setup->repeats, reference_error);
    printf("%-10s %10s %12s %22s %14s\n", "placed by", "Mpaths/s", "in the disc", "s to relative RMSE",
           "slower than fv");
    for (int i = 0; i < count; i++) {
        const double seconds = bench_median(ways[i].reached, setup->repeats);
        printf("%-10s %10.3f %10.2f %% %13.3f for %.3g %12.1f x\n", ways[i].distribution->name,
               1e-6 * bench_median(ways[i].paths_per_second, setup->repeats), 100.0 * ways[i].disc_share,
               seconds, setup->target, seconds / bench_median(ways[0].reached, setup->repeats));
    }
}

static bool plot(const struct setup *setup, const struct way *ways, int count)
{
    char error[DMN_FILE_ERROR_SIZE];
    struct dmn_chart chart;
    if (!dmn_chart_begin(&chart, error)) return bench_fail(error);
    FILE *gnuplot = chart.commands;
    fprintf(gnuplot,
            "set terminal svg size 800,560 font 'sans,14' background 'white'\nset logscale xy\n"
            "set xlabel 'rendering time, s'\nset ylabel 'relative RMSE of the gaze disc (5.79 degrees)'\nset "
            "grid\n"
            "set key top right\nplot %g with lines dashtype 2 linecolor 'grey' title 'target'",
            setup->target);
    for (int i = 0; i < count; i++)
        fprintf(gnuplot, ", '-' with lines linewidth 2 title '%s: %s'", ways[i].distribution->name,
                ways[i].distribution->summary);
    fprintf(gnuplot, "\n");
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < ways[i].points; k++)
            fprintf(gnuplot, "%g %g\n", ways[i].time[k], ways[i].error[k]);
        fprintf(gnuplot, "e\n");
    }
    return dmn_chart_end(&chart, setup->plot, 0666, error) || bench_fail(error);
}

int bench_converge(int count, char **arguments)
{
    struct setup setup;
    char error[RND_ERROR_SIZE];
    if (!parse(count, arguments, &setup)) return 2;
    struct rnd_scene *scene = rnd_scene_load(&setup.scene, error);
    if (!scene) {
        fprintf(stderr, "fovea-bench: %s\n", error);
        return 1;
    }
    static struct way ways[MAX_WAYS];
    int n = 0;
    for (const struct rnd_distribution *d; n < MAX_WAYS && (d = rnd_distribution_at((size_t)n)); n++)
        ways[n].distribution = d;
    double reference_error;
    const size_t pixels = (size_t)setup.width * (size_t)setup.width / 2;
    float *film = malloc(pixels * 3 * sizeof *film);
    setup.disc = malloc(pixels * sizeof *setup.disc);
    if (!setup.disc) exit(1);
    rnd_weigh_ring(setup.width, setup.width / 2, aim_at(&setup, 1.0f).gaze, 0.0f, RAD(DISC_DEG), setup.disc);
    float *reference = make_reference(scene, &setup, &reference_error);
    bool ok = film && reference;
    for (int r = 0; ok && r < setup.repeats; r++) ok = race(scene, &setup, ways, n, r, reference, film);
    fprintf(stderr, "\r%70s\r", "");
    if (ok) (setup.json ? print_json : print_table)(&setup, ways, n, reference_error);
    if (ok && setup.plot) ok = plot(&setup, ways, n);
    free(film);
    free(reference);
    free(setup.disc);
    rnd_scene_destroy(scene);
    return ok ? 0 : 1;
}
