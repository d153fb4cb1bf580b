/* Paths and rays per second, and where the time goes, compared with Embree alone tracing the same rays. Both
 * run in turns, so that a machine that slows down slows both. Processor time and wall time are printed:
 * beside other work, processor time says more. */
#include "bench.h"
#include "renderer.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TURNS = 99 };

struct setup {
    struct rnd_scene_options scene;
    float gaze_deg[2];
    int width, bounces, turns, batch;
    double seconds; /* for each measurement in a turn */
    bool json;
};

/* What is measured in turns. */
enum { FV, OD, FV_ONE_THREAD, WAYS };
static const char *const way_name[WAYS] = {"fv", "od", "fv, 1 thread"};

struct figures {
    double paths[MAX_TURNS], rays[MAX_TURNS]; /* a second */
    double place[MAX_TURNS];                  /* s a path */
    double share[MAX_TURNS][6];               /* shares of the threads' time, in the order of share_name */
    double cpu[MAX_TURNS];                    /* paths per second of processor time */
    double traversal[MAX_TURNS];              /* the same for Embree alone, with the same rays */
};
static const char *const share_name[6] = {"rays", "surface", "light", "scatter", "film", "place and wait"};

static const char help[] =
    "usage: fovea-bench throughput [OPTION...]\n"
    "Paths and rays per second, where the time goes, and the same rays traced again by Embree "
    "alone.\n" BENCH_SCENE_HELP
    "  --gaze A,E         azimuth (right) and elevation of the gaze, deg; default 30,-10\n"
    "  --width N          of the film, pixels; default 2048\n"
    "  --bounces N        default 4; 0: Russian roulette alone\n"
    "  --batch N          paths of a batch; default 4096\n"
    "  --turns N          medians over so many are printed; default 5\n"
    "  --seconds S        of each measurement in a turn; default 1\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"gaze", BENCH_FLOAT, out->gaze_deg, 2, -360, 360},
        {"width", BENCH_INT, &out->width, 1, 1, INT_MAX},
        {"bounces", BENCH_INT, &out->bounces, 1, 0, INT_MAX},
        {"batch", BENCH_INT, &out->batch, 1, 1, 1 << 20},
        {"turns", BENCH_INT, &out->turns, 1, 1, MAX_TURNS},
        {"seconds", BENCH_DOUBLE, &out->seconds, 1, 1e-3, 3600},
        {0},
    };
    *out = (struct setup){
        .gaze_deg = {30, -10}, .width = 2048, .bounces = 4, .turns = 5, .batch = 4096, .seconds = 1};
    return bench_options(count, arguments, help, option, &out->scene, &out->json);
}

static struct rnd_render *create(const struct rnd_scene *scene, const struct setup *setup, int way,
                                 int *out_threads)
{
    char error[RND_ERROR_SIZE];
    const struct rnd_render_options options = {.width = setup->width,
                                               .height = setup->width / 2,
                                               .threads = way == FV_ONE_THREAD,
                                               .max_bounces = setup->bounces,
                                               .distribution =
                                                   rnd_distribution_find(way == OD ? "od" : "fv")};
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fprintf(stderr, "fovea-bench: %s\n", error);
    *out_threads = render ? rnd_render_threads(render) : 0;
    return render;
}

/* Trace batches, and in between trace the rays of one again with Embree alone, so that what slows down the
 * machine for a moment slows both. */
static void measure(struct rnd_render *render, int threads, const struct setup *setup,
                    const struct rnd_aim *aim, int turn, struct figures *to)
{
    enum { BETWEEN = 8 };
    double seconds = 0, processor = 0, paths = 0, rays = 0, place = 0, part[5] = {0};
    double played = 0, replayed = 0;
    struct rnd_batch batch;
    while (seconds < setup->seconds) {
        const double start = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int i = 0; i < BETWEEN; i++) {
            rnd_render_batch(render, aim, 0, (uint32_t)setup->batch, &batch);
            seconds += batch.seconds;
            paths += (double)batch.paths;
            rays += (double)batch.rays;
            place += batch.place_seconds;
            part[0] += batch.rays_seconds;
            part[1] += batch.surface_seconds;
            part[2] += batch.light_seconds;
            part[3] += batch.scatter_seconds;
            part[4] += batch.film_seconds;
        }
        processor += bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - start;
        double again;
        rnd_render_retrace(render, aim, (uint32_t)setup->batch, &batch, &again);
        if (again < 0) exit((fprintf(stderr, "fovea-bench: not enough memory to keep the rays\n"), 1));
        played += again;
        replayed += (double)batch.paths;
    }
    to->cpu[turn] = paths / processor;
    to->traversal[turn] = replayed / played;
    to->paths[turn] = paths / seconds;
    to->rays[turn] = rays / seconds;
    to->place[turn] = place / paths;
    to->share[turn][5] = 1.0;
    for (int i = 0; i < 5; i++) {
        to->share[turn][i] = part[i] / (seconds * threads);
        to->share[turn][5] -= to->share[turn][i];
    }
}

static void print_json(const struct setup *setup, const struct figures *f, double place_cost)
{
    json_t *ways = json_object();
    for (int w = 0; w < WAYS; w++) {
        const double paths = bench_median(f[w].paths, setup->turns),
                     cpu = bench_median(f[w].cpu, setup->turns),
                     alone = bench_median(f[w].traversal, setup->turns);
        json_t *shares = json_object();
        for (int i = 0; i < 6; i++) {
            double share[MAX_TURNS];
            for (int t = 0; t < setup->turns; t++) share[t] = f[w].share[t][i];
            json_object_set_new(shares, share_name[i], json_real(bench_median(share, setup->turns)));
        }
        json_object_set_new(ways, way_name[w],
                            json_pack("{s:f,s:f,s:f,s:f,s:f,s:o}", "paths_per_second", paths,
                                      "paths_per_processor_second", cpu, "rays_per_second",
                                      bench_median(f[w].rays, setup->turns),
                                      "traversal_alone_paths_per_processor_second", alone, "traversal_share",
                                      cpu / alone, "shares", shares));
    }
    json_t *root =
        json_pack("{s:s,s:i,s:i,s:i,s:f,s:o}", "scene", setup->scene.path, "width", setup->width, "bounces",
                  setup->bounces, "batch", setup->batch, "fv_place_cost_over_od", place_cost, "ways", ways);
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

static void print_table(const struct setup *setup, const struct figures *f, double place_cost)
{
    printf("%s, gaze %g right %g up, film %d x %d, %d bounces, batches of %d paths, medians of %d turns\n",
           setup->scene.path, (double)setup->gaze_deg[0], (double)setup->gaze_deg[1], setup->width,
           setup->width / 2, setup->bounces, setup->batch, setup->turns);
    printf("%-14s %9s %9s %9s %24s %10s\n%-14s %9s %9s %9s %11s %12s %10s  share of the threads' time, %%\n",
           "", "", "", "", "Mpaths/s of a processor", "share of", "", "Mpaths/s", "Mrays/s", "rays/path",
           "all", "Embree alone", "Embree");
    for (int w = 0; w < WAYS; w++) {
        const double paths = bench_median(f[w].paths, setup->turns),
                     rays = bench_median(f[w].rays, setup->turns), cpu = bench_median(f[w].cpu, setup->turns),
                     alone = bench_median(f[w].traversal, setup->turns);
        printf("%-14s %9.3f %9.2f %9.2f %11.3f %12.3f %8.1f %%  ", way_name[w], 1e-6 * paths, 1e-6 * rays,
               rays / paths, 1e-6 * cpu, 1e-6 * alone, 100 * cpu / alone);
        for (int i = 0; i < 6; i++) {
            double share[MAX_TURNS];
            for (int t = 0; t < setup->turns; t++) share[t] = f[w].share[t][i];
            printf("%s %.1f%s", share_name[i], 100 * bench_median(share, setup->turns), i < 5 ? ", " : "\n");
        }
    }
    printf("drawing foveated positions costs %.2f %% of a batch more than uniform ones\n", 100 * place_cost);
}

int bench_throughput(int count, char **arguments)
{
    static struct figures figures[WAYS];
    struct setup setup;
    struct rnd_render *render[WAYS] = {0};
    int threads[WAYS];
    char error[RND_ERROR_SIZE];
    if (!parse(count, arguments, &setup)) return 2;
    struct rnd_scene *scene = rnd_scene_load(&setup.scene, error);
    bool ok = scene != NULL;
    if (!ok) fprintf(stderr, "fovea-bench: %s\n", error);
    struct rnd_aim aim = {.fov = {1.7f, 1.7f}, .view = {0, 0, 0, 1}};
    rnd_direction(setup.gaze_deg[0] * (float)M_PI / 180, setup.gaze_deg[1] * (float)M_PI / 180, aim.gaze);
    for (int w = 0; ok && w < WAYS; w++) ok = (render[w] = create(scene, &setup, w, &threads[w])) != NULL;
    for (int t = 0; ok && t < setup.turns; t++)
        for (int w = 0; w < WAYS; w++) {
            fprintf(stderr, "\rturn %d of %d, %s    ", t + 1, setup.turns, way_name[w]);
            measure(render[w], threads[w], &setup, &aim, t, &figures[w]);
        }
    fprintf(stderr, "\r%40s\r", "");
    if (ok) {
        double cost[MAX_TURNS]; /* extra time to place a path, over the time that a path takes */
        for (int t = 0; t < setup.turns; t++)
            cost[t] = (figures[FV].place[t] - figures[OD].place[t]) * figures[FV].paths[t];
        (setup.json ? print_json : print_table)(&setup, figures, bench_median(cost, setup.turns));
    }
    for (int w = 0; w < WAYS; w++) rnd_render_destroy(render[w]);
    rnd_scene_destroy(scene);
    return ok ? 0 : 1;
}
