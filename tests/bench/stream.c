/* What a client is sent: how many bytes, against sending the whole panorama again and again for the same
 * quality in the fovea; how much the periphery flickers; and how long tiles take. It runs the real fovead. */
#include "bench.h"
#include "chart.h"
#include "programs.h"
#include "pyramid.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEG(rad) ((rad)*180.0 / M_PI)

enum { PIXELS = RND_TILE * RND_TILE, MOST_FOVEAL = 64, MOST_A_SECOND = 120 };
static const double FOVEA_DEG = 5.79, PERIPHERY_DEG = 20, JUMP_DEG = 5, STEP_S = 0.01, FADE_MS = 100;

struct setup {
    struct rnd_scene_options scene;
    const char *fovead, *gaze, *plot;
    int width;
    double seconds;
    bool json;
};

/* Paths in a tile of level 0 as time goes on; times rise. */
struct point {
    double time_s, paths;
};
struct history {
    struct point *point;
    int count;
};

struct look {
    double time_s;
    float aim[3];
};

/* Changes of tiles beyond PERIPHERY_DEG: what the eye sees as flicker is above 1. */
struct flicker {
    uint64_t updates, seen, seen_faded;
    double square, square_faded;
};

struct run {
    const struct setup *setup;
    struct dmn_pyramid pyramid;
    float **shown;                  /* luminance of each tile as it was sent last, PIXELS of them; or NULL */
    struct history *known, *client; /* of each level-0 tile: in the daemon, and as the client has it */
    struct look *look;
    int looks;
    uint64_t generation, began_ns, tiles, bytes, fine_tiles, fine_bytes;
    struct history sum; /* bytes so far; paths stands for them */
    struct flicker flicker;
    struct dmn_histogram to_client, to_answer, to_settled; /* from encoded; from a jump of the gaze */
    float jump[3];
    uint64_t jump_ns, jump_sequence, jumps;
    bool answered, settled; /* since the jump */
};

static const char help[] =
    "usage: fovea-bench stream [OPTION...]\n"
    "fovead and one client: bytes, against sending the panorama as often as the fovea needs it to be as "
    "good;\n"
    "flicker of the periphery, as RMS of change over what the eye sees of it; and how long tiles "
    "take.\n" BENCH_SCENE_HELP "  --gaze SOURCE      default: synthetic:7\n"
    "  --width N          of the film, pixels; default 4096\n"
    "  --seconds S        from the first tile on; default 20\n"
    "  --fovead FILE      default: fovead beside this program\n"
    "  --plot FILE.svg    draw bytes over time\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"gaze", BENCH_TEXT, &out->gaze, 1, 0, 0},
        {"width", BENCH_INT, &out->width, 1, 128, 32768},
        {"seconds", BENCH_DOUBLE, &out->seconds, 1, 0.5, 3600},
        {"fovead", BENCH_TEXT, &out->fovead, 1, 0, 0},
        {"plot", BENCH_TEXT, &out->plot, 1, 0, 0},
        {0},
    };
    *out = (struct setup){.gaze = "synthetic:7", .width = 4096, .seconds = 20};
    return bench_options(count, arguments, help, option, &out->scene, &out->json);
}

static void *grow(void *list, int count, size_t size)
{
    /* at powers of two */
    void *grown = (count & (count - 1)) == 0 ? realloc(list, (size_t)(count ? 2 * count : 1) * size) : list;
    if (!grown) {
        fprintf(stderr, "fovea-bench: out of memory\n");
        exit(1);
    }
    return grown;
}

static void note(struct history *history, double time_s, double paths)
{
    /* a coarse tile tells the mean of those below it, which may be less than one of them had */
    if (history->count > 0) paths = fmax(paths, history->point[history->count - 1].paths);
    history->point = grow(history->point, history->count, sizeof *history->point);
    history->point[history->count++] = (struct point){time_s, paths};
}

/* Number of points up to that time. */
static int points_until(const struct history *history, double time_s)
{
    int low = 0, high = history->count;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (history->point[middle].time_s <= time_s)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static double last_of(const struct history *history, double time_s)
{
    const int i = points_until(history, time_s);
    return i > 0 ? history->point[i - 1].paths : 0.0;
}

static double between(const struct history *history, double time_s)
{
    const int i = points_until(history, time_s);
    if (i == 0) return 0.0;
    const struct point *from = &history->point[i - 1];
    if (i == history->count) return from->paths;
    return from->paths +
           (from[1].paths - from->paths) * (time_s - from->time_s) / (from[1].time_s - from->time_s);
}

/* Number of tiles of level 0. */
static size_t fine_tiles(const struct run *run)
{
    return (size_t)run->pyramid.level[0].columns * (size_t)run->pyramid.level[0].rows;
}

/* --- what comes --- */

static double since_start(const struct run *run, uint64_t now_ns)
{
    return 1e-9 * (double)(int64_t)(now_ns - run->began_ns);
}

/* A move of the camera, or textures that came, empty the film: begin again. */
static void begin(struct run *run, uint64_t generation, uint64_t now_ns)
{
    for (size_t i = 0; i < run->pyramid.count; i++) {
        free(run->shown[i]);
        run->shown[i] = NULL;
    }
    for (size_t i = 0; i < fine_tiles(run); i++) run->known[i].count = run->client[i].count = 0;
    run->generation = generation;
    run->began_ns = now_ns;
    run->looks = run->sum.count = 0;
    run->tiles = run->bytes = run->fine_tiles = run->fine_bytes = run->jumps = 0;
    run->flicker = (struct flicker){0};
    memset(&run->to_client, 0, sizeof run->to_client);
    memset(&run->to_answer, 0, sizeof run->to_answer);
    memset(&run->to_settled, 0, sizeof run->to_settled);
    run->answered = run->settled = true;
}

/* What is shown where a pixel of a tile will be; negative if nothing is. */
static float shown_at(const struct run *run, const Fovea__Tile *tile, int pixel)
{
    const uint32_t u = tile->x * RND_TILE + (uint32_t)pixel % RND_TILE,
                   v = tile->y * RND_TILE + (uint32_t)pixel / RND_TILE;
    for (int level = (int)tile->level; level < run->pyramid.levels; level++) {
        const int up = level - (int)tile->level;
        const float *old =
            run->shown[dmn_pyramid_index(&run->pyramid, level, (int)(tile->x >> up), (int)(tile->y >> up))];
        if (old) return old[(v >> up) % RND_TILE * RND_TILE + (u >> up) % RND_TILE];
    }
    return -1;
}

/* Take a tile's pixels, as far as a display shows them, and note how much of their change is seen. */
static bool take_pixels(struct run *run, const Fovea__Tile *tile, size_t index, const float aim[3])
{
    float rgb[3 * PIXELS], *now = malloc(PIXELS * sizeof *now);
    double square = 0, sum = 0;
    bool shown = true;
    if (!now || !pro_decode(tile->encoding, tile->data.data, tile->data.len, RND_TILE, rgb)) {
        free(now);
        return bench_fail("a tile cannot be read");
    }
    for (int i = 0; i < PIXELS; i++) {
        const float *c = &rgb[3 * i], before = shown_at(run, tile, i);
        now[i] = fminf(1.0f, 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]);
        sum += now[i];
        square += ((double)now[i] - before) * ((double)now[i] - before);
        shown &= before >= 0;
    }
    free(run->shown[index]);
    run->shown[index] = now;
    const double away = DEG(dmn_pyramid_eccentricity(&run->pyramid, (int)tile->level, index, aim));
    if (!shown || away < PERIPHERY_DEG) return true;
    const float density = dmn_pyramid_density(&run->pyramid) / (float)(1 << tile->level);
    const double change = sqrt(square / PIXELS) / fmax(sum / PIXELS, 0.01) /
                          (double)rnd_visible_flicker((float)away, density),
                 faded = change * fmin(1.0, FADE_MS / fmax(1.0, tile->fade_ms));
    run->flicker.updates++;
    run->flicker.square += change * change;
    run->flicker.square_faded += faded * faded;
    run->flicker.seen += change > 1;
    run->flicker.seen_faded += faded > 1;
    return true;
}

/* Paths of the level-0 tiles that a tile covers: what the daemon has at least, and what the client sees if it
 * is one of them itself. */
static void take_paths(struct run *run, const Fovea__Tile *tile, double time_s)
{
    const struct dmn_level *fine = &run->pyramid.level[0];
    const int span = 1 << tile->level;
    const double paths = (double)tile->samples / ((double)span * span);
    for (int y = (int)tile->y * span; y < ((int)tile->y + 1) * span && y < fine->rows; y++)
        for (int x = (int)tile->x * span; x < ((int)tile->x + 1) * span && x < fine->columns; x++) {
            const size_t at = (size_t)y * (size_t)fine->columns + (size_t)x;
            note(&run->known[at], time_s, paths);
            if (span == 1) note(&run->client[at], time_s, paths);
        }
}

static void take_times(struct run *run, const Fovea__Tile *tile, uint64_t now_ns)
{
    const size_t seen = dmn_pyramid_at(&run->pyramid, run->jump);
    const uint32_t columns = (uint32_t)run->pyramid.level[0].columns;
    const bool there = (uint32_t)seen % columns >> tile->level == tile->x &&
                       (uint32_t)seen / columns >> tile->level == tile->y &&
                       tile->gaze_sequence >= run->jump_sequence;
    const double passed_s = 1e-9 * (double)(int64_t)(now_ns - run->jump_ns);
    dmn_histogram_add(&run->to_client, 1e-9 * (double)(int64_t)(now_ns - tile->encoded_ns));
    if (there && !run->answered) dmn_histogram_add(&run->to_answer, passed_s);
    if (there && tile->settled && !run->settled) dmn_histogram_add(&run->to_settled, passed_s);
    run->answered |= there;
    run->settled |= there && tile->settled;
}

static bool take_tile(struct run *run, const Fovea__Tile *tile, uint64_t now_ns)
{
    if (tile->generation > run->generation || !run->began_ns) begin(run, tile->generation, now_ns);
    if (tile->generation < run->generation) return true;
    const size_t index = dmn_pyramid_index(&run->pyramid, (int)tile->level, (int)tile->x, (int)tile->y);
    run->tiles++;
    run->bytes += tile->data.len;
    if (tile->level == 0) run->fine_tiles++, run->fine_bytes += tile->data.len;
    note(&run->sum, since_start(run, now_ns), (double)run->bytes);
    take_paths(run, tile, since_start(run, now_ns));
    take_times(run, tile, now_ns);
    return run->looks == 0 || take_pixels(run, tile, index, run->look[run->looks - 1].aim);
}

static void take_gaze(struct run *run, const Fovea__Gaze *gaze, uint64_t now_ns)
{
    if (!run->began_ns || gaze->n_aim != 3) return;
    run->look = grow(run->look, run->looks, sizeof *run->look);
    struct look *look = &run->look[run->looks++];
    look->time_s = since_start(run, now_ns);
    memcpy(look->aim, gaze->aim, sizeof look->aim);
    const float cosine =
        look->aim[0] * run->jump[0] + look->aim[1] * run->jump[1] + look->aim[2] * run->jump[2];
    if (DEG(acosf(fmaxf(-1, fminf(1, cosine)))) < JUMP_DEG) return;
    memcpy(run->jump, look->aim, sizeof run->jump);
    run->jump_ns = gaze->arrival_ns;
    run->jump_sequence = gaze->sequence;
    run->answered = run->settled = false;
    run->jumps++;
}

static bool watch(struct run *run, const struct bench_daemon *daemon)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE];
    hello.client = "fovea-bench stream";
    hello.tiles = FOVEA__ENCODING__ENCODING_RGB9E5; /* as the page */
    hello.gaze = true;
    trk_be_prompt();
    struct pro_client *client = pro_connect(&daemon->address, &hello, -1, true, error);
    if (!client) return bench_fail(error);
    const Fovea__Welcome *film = pro_welcome(client);
    bool ok = dmn_pyramid_init(&run->pyramid, (int)film->width, (int)film->height, (int)film->levels) ||
              bench_fail("no such film");
    run->shown = calloc(run->pyramid.count + 1, sizeof *run->shown);
    run->known = calloc(run->pyramid.count + 1, sizeof *run->known);
    run->client = calloc(run->pyramid.count + 1, sizeof *run->client);
    ok = ok && ((run->shown && run->known && run->client) || bench_fail("out of memory"));
    while (ok && (!run->began_ns || since_start(run, dmn_now_ns()) < run->setup->seconds)) {
        Fovea__Message *message;
        const enum pro_result result = pro_receive(client, 50, &message, error);
        const uint64_t now_ns = dmn_now_ns();
        if (result == PRO_BROKEN) ok = bench_fail(error);
        if (result != PRO_MESSAGE) continue;
        if (message->body_case == FOVEA__MESSAGE__BODY_TILE) ok = take_tile(run, message->tile, now_ns);
        if (message->body_case == FOVEA__MESSAGE__BODY_GAZE) take_gaze(run, message->gaze, now_ns);
        fovea__message__free_unpacked(message, NULL);
    }
    pro_disconnect(client);
    return ok;
}

/* --- the panorama instead --- */

/* The level-0 tiles in the fovea: those whose middle it holds, and the one at the gaze. */
static int foveal(const struct run *run, const float aim[3], size_t out[MOST_FOVEAL])
{
    const float nearest = cosf((float)(FOVEA_DEG * M_PI / 180));
    int count = 0;
    out[count++] = dmn_pyramid_at(&run->pyramid, aim);
    for (size_t i = 0; i < fine_tiles(run) && count < MOST_FOVEAL; i++) {
        const float *centre = run->pyramid.centre[i];
        if (i != out[0] && centre[0] * aim[0] + centre[1] * aim[1] + centre[2] * aim[2] >= nearest)
            out[count++] = i;
    }
    return count;
}

static double error_of(double paths)
{
    return 1 / sqrt(fmax(1.0, paths / PIXELS));
}

/* Errors that the fovea is shown, for paths of deviation 1, as a mean over time: by the tiles that were sent;
 * and for each number of panoramas per second, if these were sent. A fovea that shows a level coarser than 0
 * counts as one with a path per pixel. */
static double errors(const struct run *run, double out_panoramas[MOST_A_SECOND + 1])
{
    const int steps = (int)(run->setup->seconds / STEP_S);
    double sum = 0, all = 0;
    memset(out_panoramas, 0, (MOST_A_SECOND + 1) * sizeof *out_panoramas);
    for (int s = 0, l = 0; s < steps; s++) {
        const double time_s = s * STEP_S;
        size_t tile[MOST_FOVEAL];
        while (l + 1 < run->looks && run->look[l + 1].time_s <= time_s) l++;
        if (run->looks == 0 || run->look[l].time_s > time_s) continue;
        const int count = foveal(run, run->look[l].aim, tile);
        all += count;
        for (int i = 0; i < count; i++) {
            sum += error_of(last_of(&run->client[tile[i]], time_s));
            for (int n = 1; n <= MOST_A_SECOND; n++)
                out_panoramas[n] += error_of(between(&run->known[tile[i]], floor(time_s * n) / n));
        }
    }
    for (int n = 1; n <= MOST_A_SECOND; n++) out_panoramas[n] /= all > 0 ? all : 1;
    return all > 0 ? sum / all : 1;
}

/* --- what is shown --- */

struct result {
    double error, panorama_bytes;
    int panoramas; /* per second, which make the fovea as good; MOST_A_SECOND: or more */
    double share;  /* of their bytes that fovead sent */
    double flicker, flicker_faded;
};

static struct result evaluate(const struct run *run)
{
    double panoramas[MOST_A_SECOND + 1];
    struct result result = {.error = errors(run, panoramas), .panoramas = 1};
    const double updates = fmax(1.0, (double)run->flicker.updates);
    while (result.panoramas < MOST_A_SECOND && panoramas[result.panoramas] > result.error) result.panoramas++;
    result.panorama_bytes =
        run->fine_tiles ? (double)run->fine_bytes / (double)run->fine_tiles * (double)fine_tiles(run) : 0;
    result.share =
        (double)run->bytes / fmax(1.0, result.panorama_bytes * result.panoramas * run->setup->seconds);
    result.flicker = sqrt(run->flicker.square / updates);
    result.flicker_faded = sqrt(run->flicker.square_faded / updates);
    return result;
}

static double ms(const struct dmn_histogram *histogram, double share)
{
    return 1e3 * dmn_histogram_quantile(histogram, share);
}

static void print_table(const struct run *run, const struct result *result)
{
    const struct setup *setup = run->setup;
    const double updates = fmax(1.0, (double)run->flicker.updates);
    printf("%s, gaze %s, film %d x %d, RGB9E5, %g s\n", setup->scene.path, setup->gaze, setup->width,
           setup->width / 2, setup->seconds);
    printf("tiles per second                 %9.1f\nMB per second                    %9.3f\n",
           (double)run->tiles / setup->seconds, 1e-6 * (double)run->bytes / setup->seconds);
    printf(
        "panoramas per second that make the fovea as good %s%d, each %.2f MB: fovead sent 1 / %.1f of that\n",
        result->panoramas == MOST_A_SECOND ? "over " : "", result->panoramas, 1e-6 * result->panorama_bytes,
        1 / fmax(1e-9, result->share));
    printf(
        "flicker beyond %g degrees, RMS over %llu updates, where 1 is seen: %.1f at once, %.1f with fades\n"
        "updates that are seen: %.1f %% at once, %.1f %% with fades\n",
        PERIPHERY_DEG, (unsigned long long)run->flicker.updates, result->flicker, result->flicker_faded,
        100 * (double)run->flicker.seen / updates, 100 * (double)run->flicker.seen_faded / updates);
    printf("%-34s %9s %9s %9s\n", "ms", "count", "p50", "p99");
    const struct {
        const char *name;
        const struct dmn_histogram *histogram;
    } row[] = {{"encoded to received", &run->to_client},
               {"gaze jump to first tile there", &run->to_answer},
               {"gaze jump to settled tile there", &run->to_settled}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        printf("%-34s %9llu %9.2f %9.2f\n", row[i].name, (unsigned long long)row[i].histogram->count,
               ms(row[i].histogram, 0.5), ms(row[i].histogram, 0.99));
    printf("%-34s %9llu\n", "gaze jumps of 5 degrees", (unsigned long long)run->jumps);
}

static json_t *times_json(const struct dmn_histogram *histogram)
{
    return json_pack("{s:I,s:f,s:f}", "count", (json_int_t)histogram->count, "p50_ms", ms(histogram, 0.5),
                     "p99_ms", ms(histogram, 0.99));
}

static void print_json(const struct run *run, const struct result *result)
{
    const struct setup *setup = run->setup;
    json_t *root = json_pack(
        "{s:s,s:i,s:f,s:I,s:I,s:f,s:i,s:f,s:f,s:{s:I,s:f,s:f,s:I,s:I},s:I,s:o,s:o,s:o}", "scene",
        setup->scene.path, "width", setup->width, "seconds", setup->seconds, "tiles", (json_int_t)run->tiles,
        "bytes", (json_int_t)run->bytes, "panorama_bytes", result->panorama_bytes, "panoramas_per_second",
        result->panoramas, "share_of_panoramas", result->share, "fovea_error", result->error, "flicker",
        "updates", (json_int_t)run->flicker.updates, "rms", result->flicker, "rms_faded",
        result->flicker_faded, "seen", (json_int_t)run->flicker.seen, "seen_faded",
        (json_int_t)run->flicker.seen_faded, "jumps", (json_int_t)run->jumps, "encoded_to_received",
        times_json(&run->to_client), "jump_to_answer", times_json(&run->to_answer), "jump_to_settled",
        times_json(&run->to_settled));
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

static bool plot(const struct run *run, const struct result *result)
{
    char error[DMN_FILE_ERROR_SIZE];
    struct dmn_chart chart;
    const double each = 1e-6 * result->panorama_bytes, a_second = result->panoramas;
    if (!dmn_chart_begin(&chart, error)) return bench_fail(error);
    fprintf(chart.commands,
            "set terminal svg size 800,560 font 'sans,14' background 'white'\nset logscale y\nset grid\n"
            "set xlabel 'time, s'\nset ylabel 'MB sent'\nset key bottom right\nset xrange [0:%g]\n"
            "plot '-' with steps linewidth 2 title 'fovead, film %d x %d', "
            "'-' with steps linewidth 2 title 'panoramas for the same fovea: %d per second'\n",
            run->setup->seconds, run->setup->width, run->setup->width / 2, result->panoramas);
    for (int i = 0; i < run->sum.count; i++)
        fprintf(chart.commands, "%g %g\n", run->sum.point[i].time_s, 1e-6 * run->sum.point[i].paths);
    fprintf(chart.commands, "e\n");
    for (int i = 0; i < (int)(run->setup->seconds * a_second); i++)
        fprintf(chart.commands, "%g %g\n", i / a_second, each * (i + 1));
    fprintf(chart.commands, "e\n");
    return dmn_chart_end(&chart, run->setup->plot, 0666, error) || bench_fail(error);
}

static void forget(struct run *run)
{
    for (size_t i = 0; i < run->pyramid.count; i++) {
        if (run->shown) free(run->shown[i]);
        if (run->known) free(run->known[i].point);
        if (run->client) free(run->client[i].point);
    }
    free(run->shown);
    free(run->known);
    free(run->client);
    free(run->look);
    free(run->sum.point);
    dmn_pyramid_finish(&run->pyramid);
}

int bench_stream(int count, char **arguments)
{
    static struct run run;
    struct setup setup;
    struct bench_daemon daemon;
    if (!parse(count, arguments, &setup)) return 2;
    const struct bench_fovead with = {&setup.scene, setup.fovead, setup.gaze, setup.width};
    run.setup = &setup;
    bool ok = bench_daemon_start(&daemon, &with) && watch(&run, &daemon);
    bench_daemon_end(&daemon);
    if (ok) {
        const struct result result = evaluate(&run);
        (setup.json ? print_json : print_table)(&run, &result);
        if (setup.plot) ok = plot(&run, &result);
    }
    forget(&run);
    return ok ? 0 : 1;
}
