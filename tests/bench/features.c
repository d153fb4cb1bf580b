/* What each feature costs in a scene that has it, and whether it costs anything otherwise. A small room with
 * the feature is compared with the same room without it, with the feature only in the file, and with it where
 * no ray comes. The rooms are traced in turns, with the same paths, by one thread. Processor time is
 * measured, because the machine may do other work. */
#include "bench.h"
#include "renderer.h"
#include "room.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TURNS = 99, WIDTH = 256, HEIGHT = WIDTH / 2, BATCH = 4096, ROUNDS = 4 };

struct setup {
    int paths, turns, bounces;
    bool json;
};

/* The rooms that are compared for a feature. */
enum { WITHOUT, WITH, UNUSED, HIDDEN, WAYS };

struct feature {
    const char *name, *against;
    struct room room;       /* with it */
    enum room_parts before; /* parts with the surface in the room without the feature */
    bool sun;
    bool unused, hidden; /* is there a room with it only in the file, or where no ray comes? */
};

/* --- features --- */

#define NON_METAL(MORE)                                                                                      \
    "{'pbrMetallicRoughness':{'metallicFactor':0" MORE                                                       \
    "},'extensions':{'KHR_materials_specular':{'specularFactor':0}}"
#define GREY                 ",'baseColorFactor':[0.7,0.7,0.7,1]"
#define PAINTED              ",'baseColorTexture':{'index':0}"
#define DIFFUSE              NON_METAL(GREY) "}"
#define GLOSSY               "{'pbrMetallicRoughness':{'metallicFactor':0.2,'roughnessFactor':0.5" GREY "}"
#define EXTENDED(EXTENSIONS) GLOSSY ",'extensions':{" EXTENSIONS "}}"
#define GLOWING              NON_METAL(GREY) ",'emissiveFactor':[8,8,8]}"
#define MATERIAL(PLAIN, LOOK)                                                                                \
    .room = {.plain = PLAIN, .surface = {.material = LOOK}, .parts = ROOM_ALL}, .unused = true, .hidden = true
#define WHOLE(...) .room = {.plain = DIFFUSE, __VA_ARGS__}

static const struct feature feature[] = {
    {"nothing, loaded twice", "diffuse", WHOLE(.instances = false)},
    {"base colour texture", "diffuse", MATERIAL(DIFFUSE, NON_METAL(PAINTED) "}")},
    {"texture transform", "base colour texture",
     MATERIAL(NON_METAL(PAINTED) "}",
              NON_METAL(",'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':"
                        "{'rotation':0.5,'scale':[1.1,0.9]}}}") "}")},
    {"vertex colours", "diffuse", .room = {.plain = DIFFUSE, .surface = {DIFFUSE, true}, .parts = ROOM_ALL},
     .unused = true, .hidden = true},
    {"alpha mask", "base colour texture",
     MATERIAL(NON_METAL(PAINTED) "}", NON_METAL(PAINTED) ",'alphaMode':'MASK'}")},
    {"alpha blend", "diffuse",
     MATERIAL(DIFFUSE, NON_METAL(",'baseColorFactor':[0.7,0.7,0.7,0.5]") ",'alphaMode':'BLEND'}")},
    {"unlit", "diffuse", MATERIAL(DIFFUSE, "{'extensions':{'KHR_materials_unlit':{}}}")},
    {"metal and roughness", "diffuse", MATERIAL(DIFFUSE, GLOSSY "}")},
    {"metal-rough map", "metal and roughness",
     MATERIAL(GLOSSY "}", "{'pbrMetallicRoughness':{'metallicRoughnessTexture':{'index':1}" GREY "}}")},
    {"normal map", "metal and roughness", MATERIAL(GLOSSY "}", GLOSSY ",'normalTexture':{'index':2}}")},
    {"clearcoat", "metal and roughness",
     MATERIAL(GLOSSY "}",
              EXTENDED("'KHR_materials_clearcoat':{'clearcoatFactor':1,'clearcoatRoughnessFactor':0.1}"))},
    {"sheen", "metal and roughness",
     MATERIAL(
         GLOSSY "}",
         EXTENDED("'KHR_materials_sheen':{'sheenColorFactor':[0.5,0.5,0.5],'sheenRoughnessFactor':0.4}"))},
    {"transmission, thin", "metal and roughness",
     MATERIAL(GLOSSY "}", EXTENDED("'KHR_materials_transmission':{'transmissionFactor':0.8}"))},
    {"glass with volume, balls", "metal and roughness",
     .room = {.plain = GLOSSY "}",
              .surface = {"{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0},'extensions':{"
                          "'KHR_materials_transmission':{'transmissionFactor':1},'KHR_materials_volume':{"
                          "'thicknessFactor':0.8,'attenuationDistance':1,'attenuationColor':[0.5,0.8,0.9]}}}",
                          false},
              .parts = ROOM_BALLS},
     .unused = true, .hidden = true},
    {"clear panes, balls", "metal and roughness",
     .room = {.plain = GLOSSY "}",
              .surface = {"{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0},'extensions':{"
                          "'KHR_materials_transmission':{'transmissionFactor':1}}}",
                          false},
              .parts = ROOM_BALLS},
     .unused = true, .hidden = true},
    {"emission, 12 triangles", "diffuse",
     .room = {.plain = DIFFUSE, .surface = {GLOWING, false}, .parts = ROOM_PANEL}, .unused = true},
    {"emission, 10000 triangles", "12 triangles",
     .room = {.plain = DIFFUSE, .surface = {GLOWING, false}, .parts = ROOM_MESHED_PANEL},
     .before = ROOM_PANEL},
    {"sun", "diffuse", WHOLE(.instances = false), .sun = true},
    {"three punctual lights", "diffuse", WHOLE(.punctual = ROOM_ALL), .unused = true},
    {"16 balls of one mesh", "16 meshes", WHOLE(.instances = true)},
};
enum { FEATURES = sizeof feature / sizeof *feature };

static bool is_there(const struct feature *f, int way)
{
    return way == UNUSED ? f->unused : way == HIDDEN ? f->hidden : true;
}

static struct rnd_scene *load(const char *directory, const struct feature *f, int way, char *out_error)
{
    struct room room = f->room;
    if (way != WITH) {
        room.parts = way == WITHOUT ? f->before : way == UNUSED ? ROOM_UNUSED : ROOM_HIDDEN;
        if (room.punctual == ROOM_ALL) room.punctual = way == UNUSED ? ROOM_UNUSED : ROOM_NOTHING;
        room.instances = false;
        if (!room.surface.material) room.parts = ROOM_NOTHING;
        if (room.parts == ROOM_NOTHING) room.surface = (struct room_surface){0};
    }
    return room_load(directory, &room, f->sun && way == WITH, out_error);
}

/* --- measurement --- */

struct figures {
    double seconds[WAYS][MAX_TURNS]; /* processor time of all paths */
    double rays[WAYS];               /* of all paths; the same in every turn */
    bool same[WAYS];                 /* is the picture, bit for bit, the same as without it? */
};

static const char help[] =
    "usage: fovea-bench features [OPTION...]\n"
    "What a feature of a scene costs: a small room with it against the same without "
    "it; with it in the file but used\n"
    "by nothing; and with it on a thing that no ray meets. Exits with 1 if either "
    "changes a bit of the picture.\n"
    "  --paths N          of each room, four times per turn; default 16384\n"
    "  --turns N          medians over so many are printed; default 15, some two minutes\n"
    "  --bounces N        default 4; 0: Russian roulette alone\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"paths", BENCH_INT, &out->paths, 1, 1, INT_MAX},
        {"turns", BENCH_INT, &out->turns, 1, 1, MAX_TURNS},
        {"bounces", BENCH_INT, &out->bounces, 1, 0, INT_MAX},
        {0},
    };
    *out = (struct setup){.paths = 16384, .turns = 15, .bounces = 4};
    return bench_options(count, arguments, help, option, NULL, &out->json);
}

/* Trace all paths again from an empty film, which gives the same picture every time. The first batch, before
 * which lights are surveyed, is not timed. */
static double trace(struct rnd_render *render, const struct rnd_scene *scene, const struct setup *setup,
                    double *out_rays)
{
    const struct rnd_aim aim = {.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1.7f, 1.7f}};
    struct rnd_batch batch;
    rnd_render_restart(render, scene, rnd_scene_info(scene)->camera);
    rnd_render_batch(render, &aim, 0, 1, &batch);
    *out_rays = 0;
    const double start = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (int left = setup->paths; left > 0; left -= BATCH) {
        rnd_render_batch(render, &aim, 0, (uint32_t)(left < BATCH ? left : BATCH), &batch);
        *out_rays += (double)batch.rays;
    }
    return bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - start;
}

/* Are the pictures the same, bit for bit? */
static bool agree(struct rnd_render *a, struct rnd_render *b)
{
    static float picture[2][WIDTH * HEIGHT * 3];
    rnd_render_resolve(a, picture[0], NULL, NULL);
    rnd_render_resolve(b, picture[1], NULL, NULL);
    return memcmp(picture[0], picture[1], sizeof picture[0]) == 0;
}

/* One turn: read the rooms anew, which puts each at another place in memory, and trace them in turns. */
static bool measure(const char *directory, const struct feature *f, const struct setup *setup, int turn,
                    struct figures *to)
{
    char error[RND_ERROR_SIZE];
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .threads = 1,
                                               .max_bounces = setup->bounces,
                                               .distribution = rnd_distribution_find("od")};
    struct rnd_scene *scene[WAYS] = {0};
    struct rnd_render *render[WAYS] = {0};
    bool ok = true;
    for (int i = 0; ok && i < WAYS; i++) {
        const int w = (turn + i) % WAYS;
        if (!is_there(f, w)) continue;
        scene[w] = load(directory, f, w, error);
        render[w] = scene[w] ? rnd_render_create(scene[w], &options, error) : NULL;
        ok = render[w] != NULL;
        if (ok) trace(render[w], scene[w], setup, &to->rays[w]); /* once without the clock */
    }
    if (!ok) fprintf(stderr, "fovea-bench: %s: %s\n", f->name, error);
    for (int r = 0; ok && r < ROUNDS; r++)
        for (int i = 0; i < WAYS; i++) {
            const int w = (turn + (r % 2 ? WAYS - 1 - i : i)) % WAYS; /* every room follows every other one */
            if (render[w]) to->seconds[w][turn] += trace(render[w], scene[w], setup, &to->rays[w]) / ROUNDS;
        }
    for (int w = 0; ok && w < WAYS; w++) to->same[w] = render[w] && agree(render[WITHOUT], render[w]);
    for (int w = 0; w < WAYS; w++) {
        rnd_render_destroy(render[w]);
        rnd_scene_destroy(scene[w]);
    }
    return ok;
}

/* --- results --- */

struct cost {
    double percent, error; /* extra time over the room without it; its standard error */
};

/* The median over all turns, and its standard error if turns are normally distributed with their median
 * deviation. */
static struct cost cost(const struct figures *f, const struct setup *setup, int way)
{
    double more[MAX_TURNS], deviation[MAX_TURNS];
    for (int t = 0; t < setup->turns; t++) more[t] = 100 * (f->seconds[way][t] / f->seconds[WITHOUT][t] - 1);
    const double median = bench_median(more, setup->turns);
    for (int t = 0; t < setup->turns; t++) deviation[t] = fabs(more[t] - median);
    return (struct cost){median,
                         1.4826 * 1.2533 * bench_median(deviation, setup->turns) / sqrt(setup->turns)};
}

/* The same cost per ray, %. */
static double cost_of_ray(const struct figures *f, const struct setup *setup)
{
    return (100 + cost(f, setup, WITH).percent) * f->rays[WITHOUT] / f->rays[WITH] - 100;
}

static json_t *cost_json(struct cost c)
{
    return json_pack("{s:f,s:f}", "percent", c.percent, "standard_error", c.error);
}

static void print_json(const struct setup *setup, const struct figures *figures)
{
    json_t *rows = json_array();
    for (int i = 0; i < FEATURES; i++) {
        const struct figures *f = &figures[i];
        json_t *row = json_pack("{s:s,s:s,s:f,s:f,s:o,s:f}", "feature", feature[i].name, "against",
                                feature[i].against, "paths_per_processor_second",
                                setup->paths / bench_median(f->seconds[WITH], setup->turns), "rays_per_path",
                                f->rays[WITH] / setup->paths, "cost", cost_json(cost(f, setup, WITH)),
                                "cost_of_ray_percent", cost_of_ray(f, setup));
        if (feature[i].unused) json_object_set_new(row, "unused", cost_json(cost(f, setup, UNUSED)));
        if (feature[i].hidden) json_object_set_new(row, "unseen", cost_json(cost(f, setup, HIDDEN)));
        json_array_append_new(rows, row);
    }
    json_t *root = json_pack("{s:i,s:i,s:i,s:o}", "paths", setup->paths, "turns", setup->turns, "bounces",
                             setup->bounces, "rows", rows);
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

static void print_cost(const struct figures *f, const struct setup *setup, bool there, int way)
{
    const struct cost c = cost(f, setup, way);
    if (there)
        printf("  %+6.1f +-%4.1f", c.percent, c.error);
    else
        printf("  %13s", "");
}

static void print_table(const struct setup *setup, const struct figures *figures)
{
    printf("a small room, one thread, %d bounces, 4 times %d paths per turn, medians of %d turns and their "
           "standard "
           "errors\n",
           setup->bounces, setup->paths, setup->turns);
    printf("%-26s %-20s %11s %9s %23s  %28s\n%-26s %-20s %11s %9s  %13s %8s  %13s  %13s\n", "", "",
           "Mpaths/s of", "", "it costs, %", "it costs where it is not, %", "feature", "against",
           "a processor", "rays/path", "of a path", "of a ray", "unused", "unseen");
    for (int i = 0; i < FEATURES; i++) {
        const struct figures *f = &figures[i];
        printf("%-26s %-20s %11.3f %9.2f", feature[i].name, feature[i].against,
               1e-6 * setup->paths / bench_median(f->seconds[WITH], setup->turns),
               f->rays[WITH] / setup->paths);
        print_cost(f, setup, true, WITH);
        printf(" %+8.1f", cost_of_ray(f, setup));
        print_cost(f, setup, feature[i].unused, UNUSED);
        print_cost(f, setup, feature[i].hidden, HIDDEN);
        putchar('\n');
    }
    printf("unused: in the file, on nothing in the scene. unseen: on a ball that no ray meets. Their "
           "pictures are the\n"
           "same bit for bit as without it. The first row says what is noise.\n");
}

static bool complain(const struct feature *f, const char *what)
{
    fprintf(stderr, "fovea-bench: %s %s\n", f->name, what);
    return false;
}

/* Check that an absent feature does not change the picture, and that a present one does. */
static bool judge(const struct figures *figures)
{
    bool ok = true;
    for (int i = 0; i < FEATURES; i++) {
        const struct feature *f = &feature[i];
        const bool *same = figures[i].same, shows = f->room.surface.material || f->room.punctual || f->sun;
        if (f->unused && !same[UNUSED]) ok = complain(f, "changes the picture though nothing uses it");
        if (f->hidden && !same[HIDDEN]) ok = complain(f, "changes the picture though no ray meets it");
        if (shows && same[WITH]) ok = complain(f, "does not change the picture");
    }
    return ok;
}

int bench_features(int count, char **arguments)
{
    static struct figures figures[FEATURES];
    struct setup setup;
    char directory[] = "/tmp/fovea-bench-XXXXXX", error[RND_ERROR_SIZE];
    if (!parse(count, arguments, &setup)) return 2;
    if (!mkdtemp(directory)) {
        fprintf(stderr, "fovea-bench: no directory can be made in /tmp\n");
        return 1;
    }
    bool ok = room_prepare(directory, error);
    if (!ok) fprintf(stderr, "fovea-bench: %s\n", error);
    for (int t = 0; ok && t < setup.turns; t++)
        for (int i = 0; ok && i < FEATURES; i++) {
            fprintf(stderr, "\rturn %d of %d, %-30s", t + 1, setup.turns, feature[i].name);
            ok = measure(directory, &feature[i], &setup, t, &figures[i]);
        }
    fprintf(stderr, "\r%60s\r", "");
    room_remove(directory);
    ok = ok && judge(figures);
    if (ok) (setup.json ? print_json : print_table)(&setup, figures);
    return ok ? 0 : 1;
}
