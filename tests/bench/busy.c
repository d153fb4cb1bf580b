/* The daemon beside other work: how soon and how evenly tiles come, how long they take from the gaze, and
 * whether paths get their share of the processors. It runs the real programs, over a Unix socket: fovead with
 * one client and nothing beside it, and then with busy loops, and more clients, of which some are stuck. */
#include "bench.h"
#include "programs.h"

#include <jansson.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_LOOPS = 64, MOST_CLIENTS = 16, MOST_TURNS = 99 };

struct setup {
    struct rnd_scene_options scene;
    const char *fovead, *gaze;
    int width, loops, clients, stuck, turns;
    double seconds;
    bool json;
};

/* Where work and processors are at a moment, s and paths. */
struct mark {
    double time, paths, daemon, loops, clients;
};

/* A client, and what it saw. */
struct client {
    struct run *run;
    pthread_t thread;
    bool failed;
    uint64_t first_ns, last_ns,
        gap_ns; /* arrival of the first and of the last tile; the longest wait for one */
    uint64_t tiles, sequence;
    struct mark from, to; /* of the later half */
    double before;        /* paths of the generations that are over */
    uint64_t paths, generation;
};

/* The daemon, and the busy loops beside it. */
struct run {
    const struct setup *setup;
    struct bench_daemon daemon;
    pid_t loop[MOST_LOOPS];
    int loops, readers;      /* clients that are not stuck */
    _Atomic int served;      /* clients that have had a tile */
    _Atomic uint64_t end_ns; /* 0 until all have */
    struct client client[MOST_CLIENTS];
    pthread_mutex_t lock;                   /* of the rest */
    struct dmn_histogram to_batch, to_tile; /* from the gaze */
    struct dmn_histogram from_batch;        /* from the begin of the batch to the tile */
    struct dmn_histogram from_encoded;      /* from the encoded tile to the client */
};

static const char help[] =
    "usage: fovea-bench busy [OPTION...]\n"
    "fovead with one client, and then beside busy loops and with more clients: the first tile, the longest\n"
    "wait for one; what passes from gaze to batch and to tile, from the begin of a batch to the tile, and "
    "from\n"
    "an encoded tile to its client; and what of their share of the processors paths get.\n" BENCH_SCENE_HELP
    "  --loops N          busy loops; default 6, and 0 with --stuck\n"
    "  --clients N        in all; default 1\n"
    "  --stuck N          of them, clients that ask for tiles and read nothing; default 0\n"
    "  --turns N          both are measured so often, in turns; medians are shown; default 1\n"
    "  --gaze SOURCE      default: synthetic:7\n"
    "  --width N          of the film, pixels; default 4096\n"
    "  --seconds S        of each measurement, from the first tile on; default 10\n"
    "  --fovead FILE      default: fovead beside this program\n"
    "  --json             one JSON object instead of the table\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"loops", BENCH_INT, &out->loops, 1, 0, MOST_LOOPS},
        {"clients", BENCH_INT, &out->clients, 1, 1, MOST_CLIENTS},
        {"stuck", BENCH_INT, &out->stuck, 1, 0, MOST_CLIENTS - 1},
        {"turns", BENCH_INT, &out->turns, 1, 1, MOST_TURNS},
        {"gaze", BENCH_TEXT, &out->gaze, 1, 0, 0},
        {"width", BENCH_INT, &out->width, 1, 128, 32768},
        {"seconds", BENCH_DOUBLE, &out->seconds, 1, 0.5, 3600},
        {"fovead", BENCH_TEXT, &out->fovead, 1, 0, 0},
        {0},
    };
    *out = (struct setup){
        .gaze = "synthetic:7", .width = 4096, .loops = -1, .clients = 1, .turns = 1, .seconds = 10};
    if (!bench_options(count, arguments, help, option, &out->scene, &out->json)) return false;
    if (out->loops < 0) out->loops = out->stuck ? 0 : 6;
    return out->stuck < out->clients ||
           bench_fail("--stuck leaves no client that reads: give more --clients");
}

/* --- processes --- */

/* Processor time of a process, s. */
static double processor(pid_t process)
{
    clockid_t clock;
    return clock_getcpuclockid(process, &clock) == 0 ? bench_seconds(clock) : 0.0;
}

static bool start_loops(struct run *run, int count)
{
    for (; run->loops < count; run->loops++) {
        const pid_t child = run->loop[run->loops] = bench_spawn();
        if (child < 0) return false;
        for (volatile unsigned turn = 0; child == 0;) turn = turn + 1;
    }
    return true;
}

/* --- clients --- */

static void take_tile(struct client *client, const Fovea__Tile *tile, uint64_t now_ns)
{
    struct run *run = client->run;
    if (client->tiles++ == 0) {
        client->first_ns = client->last_ns = now_ns;
        if (atomic_fetch_add(&run->served, 1) + 1 == run->readers)
            atomic_store(&run->end_ns, now_ns + (uint64_t)(1e9 * run->setup->seconds));
    }
    if (now_ns - client->last_ns > client->gap_ns) client->gap_ns = now_ns - client->last_ns;
    client->last_ns = now_ns;
    /* Later tiles of the same gaze would tell how long the eye has rested. */
    if (!tile->gaze_ns || tile->gaze_sequence <= client->sequence) return;
    client->sequence = tile->gaze_sequence;
    pthread_mutex_lock(&run->lock);
    dmn_histogram_add(&run->to_batch, 1e-9 * (double)(int64_t)(tile->aimed_ns - tile->gaze_ns));
    dmn_histogram_add(&run->to_tile, 1e-9 * (double)(int64_t)(now_ns - tile->gaze_ns));
    dmn_histogram_add(&run->from_batch, 1e-9 * (double)(int64_t)(now_ns - tile->aimed_ns));
    dmn_histogram_add(&run->from_encoded, 1e-9 * (double)(int64_t)(now_ns - tile->encoded_ns));
    pthread_mutex_unlock(&run->lock);
}

/* Paths and processors of the later half are compared: at first there is much that is done once. */
static void take_stats(struct client *client, const Fovea__Stats *stats)
{
    struct run *run = client->run;
    const uint64_t end_ns = atomic_load(&run->end_ns);
    if (stats->generation != client->generation) client->before += (double)client->paths;
    client->generation = stats->generation;
    client->paths = stats->samples;
    if (!end_ns || stats->time_ns < end_ns - (uint64_t)(0.5e9 * run->setup->seconds)) return;
    client->to = (struct mark){1e-9 * (double)stats->time_ns, client->before + (double)client->paths,
                               processor(run->daemon.process), 0.0, bench_seconds(CLOCK_PROCESS_CPUTIME_ID)};
    for (int i = 0; i < run->loops; i++) client->to.loops += processor(run->loop[i]);
    if (client->from.time == 0.0) client->from = client->to;
}

static void *watch(void *argument)
{
    struct client *client = argument;
    struct run *run = client->run;
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE];
    hello.client = "fovea-bench busy";
    hello.tiles = FOVEA__ENCODING__ENCODING_JPEG; /* as foveactl watch */
    hello.stats = true;
    trk_be_prompt();
    struct pro_client *connection = pro_connect(&run->daemon.address, &hello, -1, true, error);
    client->failed = !connection;
    while (!client->failed) {
        const uint64_t end_ns = atomic_load(&run->end_ns);
        Fovea__Message *message;
        const enum pro_result result = pro_receive(connection, 50, &message, error);
        const uint64_t now_ns = dmn_now_ns();
        client->failed = result == PRO_BROKEN;
        /* after the end it goes on until there are two marks to compare */
        const bool ended = end_ns && now_ns >= end_ns && client->to.time > client->from.time;
        if (result == PRO_MESSAGE) {
            if (!ended && message->body_case == FOVEA__MESSAGE__BODY_TILE)
                take_tile(client, message->tile, now_ns);
            if (!ended && message->body_case == FOVEA__MESSAGE__BODY_STATS)
                take_stats(client, message->stats);
            fovea__message__free_unpacked(message, NULL);
        }
        if (ended) break;
    }
    if (client->failed) fprintf(stderr, "fovea-bench: %s\n", error);
    const uint64_t silent_ns = dmn_now_ns() - client->last_ns;
    if (silent_ns > client->gap_ns) client->gap_ns = silent_ns;
    pro_disconnect(connection);
    return NULL;
}

/* A client that asks for tiles and then reads nothing. */
static struct pro_client *get_stuck(const struct run *run)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE];
    hello.client = "fovea-bench stuck";
    hello.tiles = FOVEA__ENCODING__ENCODING_HALF_ZSTD;
    hello.stats = hello.gaze = true;
    struct pro_client *client = pro_connect(&run->daemon.address, &hello, -1, true, error);
    if (!client) bench_fail(error);
    return client;
}

/* --- figures --- */

enum {
    FIRST,
    GAP,
    BATCH_P50,
    BATCH_P99,
    TILE_P50,
    TILE_P99,
    ANSWER_P50,
    ANSWER_P99,
    SENT_P50,
    SENT_P99,
    TILES,
    PATHS,
    DAEMON,
    EACH,
    CLIENTS,
    LOOP,
    FIGURES
};

/* What is printed: its key, its name, and the factor from seconds or pieces to its unit. */
static const struct {
    const char *key, *name;
    double unit;
} figure_of[FIGURES] = {
    [FIRST] = {"first_tile_s", "socket to first tile, s", 1},
    [GAP] = {"longest_gap_s", "longest wait for a tile, s", 1},
    [BATCH_P50] = {"gaze_to_batch_p50_ms", "gaze to batch, ms: p50", 1e3},
    [BATCH_P99] = {"gaze_to_batch_p99_ms", "                   p99", 1e3},
    [TILE_P50] = {"gaze_to_tile_p50_ms", "gaze to tile, ms:  p50", 1e3},
    [TILE_P99] = {"gaze_to_tile_p99_ms", "                   p99", 1e3},
    [ANSWER_P50] = {"batch_to_tile_p50_ms", "batch to tile, ms: p50", 1e3},
    [ANSWER_P99] = {"batch_to_tile_p99_ms", "                   p99", 1e3},
    [SENT_P50] = {"encoded_to_tile_p50_ms", "encoded to tile, ms: p50", 1e3},
    [SENT_P99] = {"encoded_to_tile_p99_ms", "                     p99", 1e3},
    [TILES] = {"tiles_per_second", "tiles per second to a client", 1},
    [PATHS] = {"mpaths_per_second", "Mpaths per second", 1e-6},
    [DAEMON] = {"processors_of_daemon", "processors that fovead had", 1},
    [EACH] = {"mpaths_per_processor_second", "Mpaths per second of a processor", 1e-6},
    [CLIENTS] = {"processors_of_clients", "processors that clients had", 1},
    [LOOP] = {"processors_of_a_loop", "processors that a busy loop had", 1},
};

/* A part of a whole; 0 where a machine that is too busy has left nothing. */
static double share(double part, double whole)
{
    return whole > 0 ? part / whole : 0;
}

static void evaluate(const struct run *run, double figure[FIGURES])
{
    const struct client *first = &run->client[0];
    const double seconds = first->to.time - first->from.time;
    memset(figure, 0, FIGURES * sizeof *figure);
    for (const struct client *c = run->client; c < run->client + run->readers; c++) {
        figure[FIRST] = fmax(figure[FIRST], 1e-9 * (double)(c->first_ns - run->daemon.socket_ns));
        figure[GAP] = fmax(figure[GAP], 1e-9 * (double)c->gap_ns);
        figure[TILES] += (double)c->tiles / run->setup->seconds / run->readers;
    }
    figure[BATCH_P50] = dmn_histogram_quantile(&run->to_batch, 0.5);
    figure[BATCH_P99] = dmn_histogram_quantile(&run->to_batch, 0.99);
    figure[TILE_P50] = dmn_histogram_quantile(&run->to_tile, 0.5);
    figure[TILE_P99] = dmn_histogram_quantile(&run->to_tile, 0.99);
    figure[ANSWER_P50] = dmn_histogram_quantile(&run->from_batch, 0.5);
    figure[ANSWER_P99] = dmn_histogram_quantile(&run->from_batch, 0.99);
    figure[SENT_P50] = dmn_histogram_quantile(&run->from_encoded, 0.5);
    figure[SENT_P99] = dmn_histogram_quantile(&run->from_encoded, 0.99);
    figure[PATHS] = (first->to.paths - first->from.paths) / seconds;
    figure[DAEMON] = (first->to.daemon - first->from.daemon) / seconds;
    figure[EACH] = share(figure[PATHS], figure[DAEMON]);
    figure[CLIENTS] = (first->to.clients - first->from.clients) / seconds;
    if (run->loops > 0) figure[LOOP] = (first->to.loops - first->from.loops) / seconds / run->loops;
}

/* One start of fovead, beside so many busy loops, with so many clients that read and so many that are stuck.
 */
static bool measure(const struct setup *setup, int loops, int readers, int stuck, double figure[FIGURES])
{
    static struct run run;
    struct pro_client *held[MOST_CLIENTS] = {NULL};
    run = (struct run){.setup = setup, .readers = readers, .lock = PTHREAD_MUTEX_INITIALIZER};
    const struct bench_fovead with = {&setup->scene, setup->fovead, setup->gaze, setup->width};
    bool ok = start_loops(&run, loops) && bench_daemon_start(&run.daemon, &with);
    int watching = 0;
    for (int i = 0; ok && i < stuck; i++) ok = (held[i] = get_stuck(&run));
    for (; ok && watching < readers; watching++) {
        run.client[watching].run = &run;
        ok = pthread_create(&run.client[watching].thread, NULL, watch, &run.client[watching]) == 0;
    }
    if (watching < readers) atomic_store(&run.end_ns, 1);
    for (int i = 0; i < watching; i++) {
        pthread_join(run.client[i].thread, NULL);
        ok = ok && !run.client[i].failed;
    }
    if (ok) evaluate(&run, figure);
    for (int i = 0; i < stuck; i++) pro_disconnect(held[i]);
    bench_daemon_end(&run.daemon);
    for (int i = 0; i < run.loops; i++) bench_end(run.loop[i], SIGKILL);
    return ok;
}

/* What paths would have a second if every thread that computes had as much of the processors as every other,
 * by how many threads there are; and by what a busy loop really had, where others use the machine too. */
static void fair_share(const struct setup *setup, const double alone[FIGURES], const double beside[FIGURES],
                       double *out_by_number, double *out_by_loops)
{
    const double processors = (double)sysconf(_SC_NPROCESSORS_ONLN);
    *out_by_number = alone[PATHS] * processors / (processors + setup->loops);
    *out_by_loops = alone[EACH] * processors * beside[LOOP];
}

/* The figures of all turns, and then their medians. */
struct turns {
    double alone[FIGURES][MOST_TURNS], beside[FIGURES][MOST_TURNS], ratio[FIGURES][MOST_TURNS];
    double alone_median[FIGURES], beside_median[FIGURES], ratio_median[FIGURES];
};

static bool measure_turns(const struct setup *setup, struct turns *out)
{
    const int readers = setup->clients - setup->stuck;
    for (int turn = 0; turn < setup->turns; turn++) {
        double alone[FIGURES], beside[FIGURES];
        if (!measure(setup, 0, 1, 0, alone) || !measure(setup, setup->loops, readers, setup->stuck, beside))
            return false;
        for (int i = 0; i < FIGURES; i++) {
            out->alone[i][turn] = alone[i];
            out->beside[i][turn] = beside[i];
            out->ratio[i][turn] = share(beside[i], alone[i]);
        }
    }
    for (int i = 0; i < FIGURES; i++) {
        out->alone_median[i] = bench_median(out->alone[i], setup->turns);
        out->beside_median[i] = bench_median(out->beside[i], setup->turns);
        out->ratio_median[i] = bench_median(out->ratio[i], setup->turns);
    }
    return true;
}

static void print_json(const struct setup *setup, const struct turns *turns, double by_number,
                       double by_loops)
{
    const double *alone = turns->alone_median, *beside = turns->beside_median;
    json_t *root =
        json_pack("{s:s,s:i,s:i,s:i,s:i,s:i,s:f,s:f,s:f,s:o,s:o}", "scene", setup->scene.path, "width",
                  setup->width, "loops", setup->loops, "clients", setup->clients, "stuck", setup->stuck,
                  "turns", setup->turns, "paths_ratio", turns->ratio_median[PATHS],
                  "paths_per_processor_second_ratio", turns->ratio_median[EACH], "share_by_number",
                  share(beside[PATHS], by_number), "alone", json_object(), "beside", json_object());
    if (setup->loops > 0)
        json_object_set_new(root, "share_by_loops", json_real(share(beside[PATHS], by_loops)));
    for (int i = 0; i < FIGURES; i++) {
        json_object_set_new(json_object_get(root, "alone"), figure_of[i].key,
                            json_real(alone[i] * figure_of[i].unit));
        json_object_set_new(json_object_get(root, "beside"), figure_of[i].key,
                            json_real(beside[i] * figure_of[i].unit));
    }
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

int bench_busy(int count, char **arguments)
{
    static struct turns turns;
    const double *alone = turns.alone_median, *beside = turns.beside_median;
    struct setup setup;
    double by_number, by_loops;
    if (!parse(count, arguments, &setup)) return 2;
    if (!measure_turns(&setup, &turns)) return 1;
    fair_share(&setup, alone, beside, &by_number, &by_loops);
    if (setup.json) return print_json(&setup, &turns, by_number, by_loops), 0;
    printf("%s, gaze %s, film %d x %d, %g s each, turns %d\n%-34s %9d %9d\n%-34s %9d %9d\n%-34s %9d %9d\n",
           setup.scene.path, setup.gaze, setup.width, setup.width / 2, setup.seconds, setup.turns,
           "busy loops beside it", 0, setup.loops, "clients", 1, setup.clients, "of them stuck", 0,
           setup.stuck);
    for (int i = 0; i < FIGURES; i++)
        printf("%-34s %9.3f %9.3f\n", figure_of[i].name, alone[i] * figure_of[i].unit,
               beside[i] * figure_of[i].unit);
    printf("%-34s %9s %8.0f %% of that alone\n%-34s %9s %8.0f %% of that alone\n", "Mpaths per second", "",
           100 * turns.ratio_median[PATHS], "Mpaths per second of a processor", "",
           100 * turns.ratio_median[EACH]);
    if (setup.loops > 0)
        printf("%-34s %9s %9.3f  %.0f %% of it\n%-34s %9s %9.3f  %.0f %% of it\n",
               "fair share by number of threads", "", 1e-6 * by_number, 100 * share(beside[PATHS], by_number),
               "fair share by what a loop had", "", 1e-6 * by_loops, 100 * share(beside[PATHS], by_loops));
    return 0;
}
