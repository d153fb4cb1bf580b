/* The time from the start to the first coarse picture, step by step, and the memory per pixel of the film. */
#include "bench.h"
#include "renderer.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_TURNS = 99, BATCH = 4096 };

struct setup {
    struct rnd_scene_options scene;
    int width, turns;
    bool json;
};

enum { READ, BUILD, OUTLINE, AFTER_READ, TEXTURED, FIGURES };
static const char *const name[FIGURES] = {"read", "build", "outline", "after_read", "textured"};

static const char help[] =
    "usage: fovea-bench startup [OPTION...]\n"
    "Time from nothing to the first coarse picture: reading the file; tree and "
    "lights; a path in every cell of\n"
    "16 x 16 pixels; and to the first with its textures, while batches go on. And the "
    "memory of a film pixel.\n" BENCH_SCENE_HELP "  --width N          of the film, pixels; default 4096\n"
    "  --turns N          medians over so many are printed; default 5\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"width", BENCH_INT, &out->width, 1, 1, INT_MAX},
        {"turns", BENCH_INT, &out->turns, 1, 1, MAX_TURNS},
        {0},
    };
    *out = (struct setup){.scene.textures_later = true, .width = 4096, .turns = 5};
    return bench_options(count, arguments, help, option, &out->scene, &out->json);
}

/* Resident memory of this process, bytes. */
static double resident(void)
{
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%*d %ld", &pages) != 1) pages = 0;
    if (file) fclose(file);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static bool measure(const struct setup *setup, int turn, double figure[FIGURES][MAX_TURNS],
                    struct rnd_scene_info *out_info, double *out_bytes)
{
    char error[RND_ERROR_SIZE];
    const struct rnd_aim aim = {.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1.7f, 1.7f}};
    const struct rnd_render_options options = {
        .width = setup->width, .height = setup->width / 2, .distribution = rnd_distribution_find("od")};
    struct rnd_scene *scene = rnd_scene_load(&setup->scene, error);
    const double start = bench_seconds(CLOCK_MONOTONIC);
    struct rnd_render *render = scene ? rnd_render_create(scene, &options, error) : NULL;
    struct rnd_batch batch;
    if (render) {
        *out_info = *rnd_scene_info(scene);
        rnd_render_outline(render, &aim, 0, &batch);
        figure[READ][turn] = out_info->read_seconds;
        figure[BUILD][turn] = out_info->build_seconds;
        figure[OUTLINE][turn] = bench_seconds(CLOCK_MONOTONIC) - start;
        figure[AFTER_READ][turn] = figure[BUILD][turn] + figure[OUTLINE][turn];
        const char *warnings;
        enum rnd_textures textures;
        while ((textures = rnd_scene_take_textures(scene, &warnings)) == RND_TEXTURES_READING)
            rnd_render_batch(render, &aim, 0, BATCH, &batch);
        if (*warnings) exit((fprintf(stderr, "fovea-bench: %s", warnings), 1));
        rnd_render_restart(render, scene, out_info->camera);
        rnd_render_outline(render, &aim, 0, &batch);
        figure[TEXTURED][turn] = figure[BUILD][turn] + bench_seconds(CLOCK_MONOTONIC) - start;
        *out_info = *rnd_scene_info(scene);
        rnd_render_destroy(render);
        const double before = resident();
        if (!(render = rnd_render_create(scene, &options, error)))
            exit((fprintf(stderr, "fovea-bench: %s\n", error), 1));
        /* Twice one path per eight pixels: that touches both halves of the film, and nearly all of its pages.
         */
        for (int i = 0; i < 2; i++)
            rnd_render_batch(render, &aim, 0, (uint32_t)(setup->width * (setup->width / 16)), &batch);
        *out_bytes = (resident() - before) / ((double)setup->width * setup->width / 2);
    } else {
        fprintf(stderr, "fovea-bench: %s\n", error);
    }
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
    return render != NULL;
}

int bench_startup(int count, char **arguments)
{
    static double figure[FIGURES][MAX_TURNS];
    struct setup setup;
    struct rnd_scene_info info = {0};
    double bytes = 0, largest = 0, median[FIGURES];
    if (!parse(count, arguments, &setup)) return 2;
    setup.scene.image_program =
        rnd_image_program_create(); /* as in fovead, the program that reads pictures starts once */
    for (int t = 0; t < setup.turns; t++) {
        if (!measure(&setup, t, figure, &info, &bytes)) return 1;
        largest = fmax(largest, bytes); /* a later turn may reuse memory of an earlier one */
    }
    rnd_image_program_destroy(setup.scene.image_program);
    for (int i = 0; i < FIGURES; i++) median[i] = bench_median(figure[i], setup.turns);
    if (setup.json) {
        json_t *root = json_pack("{s:s,s:I,s:i,s:f}", "scene", setup.scene.path, "triangles",
                                 (json_int_t)info.triangles, "width", setup.width, "bytes_a_pixel", largest);
        for (int i = 0; i < FIGURES; i++) {
            char key[64];
            snprintf(key, sizeof key, "%s_seconds", name[i]);
            json_object_set_new(root, key, json_real(median[i]));
        }
        json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
        putchar('\n');
        json_decref(root);
        return 0;
    }
    printf("%s, %llu triangles, %u textures of %.1f MiB, film %d x %d, medians of %d\n", setup.scene.path,
           (unsigned long long)info.triangles, info.textures, (double)info.texture_bytes / 1048576.0,
           setup.width, setup.width / 2, setup.turns);
    printf("%-42s %8.3f s\n%-42s %8.3f s\n%-42s %8.3f s\n%-42s %8.3f s\n%-42s %8.3f s\n%-42s %8.1f bytes\n",
           "reading the file", median[READ], "tree, lights", median[BUILD], "film and first coarse picture",
           median[OUTLINE], "after the file is read", median[AFTER_READ],
           "after the file is read, with all textures", median[TEXTURED], "per pixel of the film", largest);
    return 0;
}
