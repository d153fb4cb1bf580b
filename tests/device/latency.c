/* latency: how long it takes from a tracker's report to the first batch of paths that is aimed by it, while
 * rendering.
 *
 *   umockdev-wrapper device_latency SCENE [SAMPLES [HZ]]
 *
 * A fake HID tracker sends through umockdev's hidraw, which costs more than the kernel's. One thread reads
 * the source, as fovead's does. Another renders batches of 2.5 ms; a new sample cuts a batch short, as a jump
 * of the gaze does in fovead. Prints for all samples, in ms: from sent to arrived, from arrived to the start
 * of the first batch after it, and the sum. Exit code 1 if the 99th percentile of the sum is over 5 ms. */
#include "fake.h"

#include "renderer.h"
#include "tracker.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_SAMPLES = 60000, WIDTH = 1024 };
static const double bar_ms = 5, batch_seconds = 0.0025;

struct gaze { /* under lock */
    pthread_mutex_t lock;
    struct rnd_aim aim;
    uint64_t sent[MAX_SAMPLES], arrived[MAX_SAMPLES], aimed[MAX_SAMPLES];
    atomic_bool stale;
    int samples, waiting; /* waiting: the first sample that no batch has begun after */
};

struct reader {
    struct trk_source *source;
    struct fake_device *device;
    struct gaze *gaze;
    atomic_bool stop;
};

static uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

static void *read_gaze(void *argument)
{
    struct reader *reader = argument;
    struct gaze *gaze = reader->gaze;
    char error[TRK_ERROR_SIZE];
    trk_be_prompt();
    /* Number of reports. A sample that says that gaze was lost has a number of its own, and was not sent. */
    uint64_t sent = 0;
    while (!atomic_load(&reader->stop)) {
        struct trk_sample sample;
        if (trk_read(reader->source, now_ns() + 50000000, &sample, error) != TRK_SAMPLE) continue;
        pthread_mutex_lock(&gaze->lock);
        if (trk_world_direction(&sample, gaze->aim.gaze)) {
            uint64_t sent_ns = fake_sent_ns(reader->device, sent++);
            if (gaze->samples < MAX_SAMPLES) {
                gaze->sent[gaze->samples] = sent_ns;
                gaze->arrived[gaze->samples++] = sample.arrival_ns;
                atomic_store(&gaze->stale, true);
            }
        }
        pthread_mutex_unlock(&gaze->lock);
    }
    return NULL;
}

static void render_until(struct rnd_render *render, struct gaze *gaze, int samples)
{
    uint32_t paths = 2048;
    while (gaze->waiting < samples) {
        struct rnd_batch batch;
        pthread_mutex_lock(&gaze->lock);
        struct rnd_aim aim = gaze->aim;
        atomic_store(&gaze->stale, false);
        uint64_t start_ns = now_ns();
        while (gaze->waiting < gaze->samples) gaze->aimed[gaze->waiting++] = start_ns;
        pthread_mutex_unlock(&gaze->lock);
        rnd_render_batch(render, &aim, start_ns, paths, &batch);
        double change = batch_seconds / fmax(batch.seconds, 1e-6) * (double)batch.paths / paths;
        paths = (uint32_t)(paths * (1 + (fmin(fmax(change, 0.5), 2) - 1) / 2));
        if (paths < 256) paths = 256;
    }
}

static int ascending(const void *a, const void *b)
{
    double difference = *(const double *)a - *(const double *)b;
    return difference < 0 ? -1 : difference > 0;
}

/* Print a row of the table. Returns the 99th percentile. */
static double row(const char *name, const uint64_t *from, const uint64_t *to, int count)
{
    static double ms[MAX_SAMPLES];
    for (int i = 0; i < count; i++) ms[i] = ((double)to[i] - (double)from[i]) * 1e-6;
    qsort(ms, (size_t)count, sizeof *ms, ascending);
    double p99 = ms[(int)(0.99 * (count - 1))];
    printf("%-22s %8.3f %8.3f %8.3f %8.3f\n", name, ms[count / 2], ms[(int)(0.95 * (count - 1))], p99,
           ms[count - 1]);
    return p99;
}

static int report(const struct gaze *gaze, double hz)
{
    /* In the first half second the device is opened and the length of batches is found. */
    int skip = (int)(hz / 2), count = gaze->waiting - skip;
    printf("%d samples at %.0f Hz; ms  p50      p95      p99      max\n", count, hz);
    row("sent to arrived", gaze->sent + skip, gaze->arrived + skip, count);
    row("arrived to batch", gaze->arrived + skip, gaze->aimed + skip, count);
    double p99 = row("sent to batch", gaze->sent + skip, gaze->aimed + skip, count);
    printf("p99 %.3f ms, bar %.0f ms: %s\n", p99, bar_ms, p99 < bar_ms ? "held" : "missed");
    return p99 < bar_ms ? 0 : 1;
}

int main(int count, char **arguments)
{
    static struct gaze gaze = {.lock = PTHREAD_MUTEX_INITIALIZER};
    double hz = count > 3 ? atof(arguments[3]) : 500;
    int samples = count > 2 ? atoi(arguments[2]) : 5000;
    char error[512] = "expected SCENE [SAMPLES [HZ]], more samples than half a second has";
    struct rnd_scene_options scene_options = {.path = count > 1 ? arguments[1] : NULL};
    struct rnd_render_options render_options = {
        .width = WIDTH, .height = WIDTH / 2, .distribution = rnd_distribution_find("fv")};
    struct rnd_scene *scene = count > 1 ? rnd_scene_load(&scene_options, error) : NULL;
    struct rnd_render *render = scene ? rnd_render_create(scene, &render_options, error) : NULL;
    int result = 2;
    if (!(samples > hz / 2 + 1 && samples < MAX_SAMPLES)) goto end;
    gaze.aim =
        (struct rnd_aim){.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1.7f, 1.7f}, .stale = &gaze.stale};
    if (!render) goto end;

    struct fake *fake = fake_create();
    struct reader reader = {.gaze = &gaze, .device = fake_plug(fake, FAKE_HID, hz)};
    struct trk_source_options source_options = {.spec = "hid"};
    reader.source = trk_open(&source_options, error);
    pthread_t thread;
    if (reader.source && pthread_create(&thread, NULL, read_gaze, &reader) == 0) {
        struct trk_status status;
        trk_get_status(reader.source, &status);
        fprintf(stderr, "%s\n", status.description);
        render_until(render, &gaze, samples);
        atomic_store(&reader.stop, true);
        pthread_join(thread, NULL);
        result = report(&gaze, hz);
    }
    trk_close(reader.source);
    fake_destroy(fake);
end:
    if (result == 2) fprintf(stderr, "device_latency: %s\n", error);
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
    return result;
}
