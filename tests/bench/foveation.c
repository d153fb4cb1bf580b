/* How far the direction that is rendered for is from the true gaze: with the filter off, with the filter, and
 * with prediction, at several latencies. And how soon the onset of a saccade shows.
 *
 * The synthetic observer runs at ten times the tracker's rate, so that latencies are not rounded to the
 * tracker's samples; every tenth sample is what the tracker delivers. Calibration bias is left out, because
 * no filter removes it and it would hide their effect. Only times at which the tracker can see the eye count.
 */
#include "bench.h"
#include "chart.h"
#include "source/observer.h"
#include "tracker.h"

#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OVERSAMPLE = 10, RATE_HZ = 120, WAYS = 3, LATENCIES = 4, PHASES = 3, AMPLITUDES = 6, MAX_LATE = 100 };

static const char *const way_names[WAYS] = {"filter off", "filter on", "prediction on"};
static const struct trk_attention_options way_options[WAYS] = {{.raw = true}, {0}, {.predict = true}};
static const int latency_ms[LATENCIES] = {0, 20, 50, 80};
static const char *const phase_names[PHASES] = {"fixation", "100 ms after saccades", "all"};
/* Classes of saccades by amplitude, deg. Each ends where the next one begins. */
static const double amplitude_from[AMPLITUDES + 1] = {0, 1, 2, 3, 5, 10, 31};

/* Smaller saccades are microsaccades, after which nobody renders anew. */
static const double seen_deg = 1;

/* The chart: time since the onset of saccades of at least 5 degrees. */
enum { CHART_FROM_MS = -50, CHART_TO_MS = 300, CHART_STEP_MS = 5 };
enum { CHART_BINS = (CHART_TO_MS - CHART_FROM_MS) / CHART_STEP_MS };
static const double chart_amplitude_deg = 5;

struct setup {
    int seed;
    double seconds, noise_deg;
    bool json;
    const char *plot;
};

/* The truth at one tick of the observer. */
struct tick {
    float direction[3];
    bool hidden, is_saccade;
    float since_end_s; /* since the end of the last saccade */
    uint32_t saccade;  /* index of the current saccade, or of the last one; 0 before the first */
};

struct saccade {
    double onset_s, end_s, amplitude_deg;
    bool hidden; /* a blink or drop-out is too near to judge it */
};

struct world {
    size_t ticks, samples, saccades;
    struct tick *tick;
    struct saccade *saccade; /* from 1 */
    struct trk_sample *sample;
    struct trk_aim *gaze[WAYS];
};

struct onset {
    int count, missed, late[MAX_LATE]; /* late[n]: found n samples after the first one that could show it */
};

struct result {
    double median[WAYS][LATENCIES][PHASES], p95[WAYS][LATENCIES][PHASES];
    struct onset onset[AMPLITUDES];
    double false_per_minute, noise_deg;
    double chart[WAYS][LATENCIES][CHART_BINS]; /* median */
    double landing_median, landing_p95;        /* error of the prediction when saccades end */
};

static const char help[] =
    "usage: fovea-bench foveation [OPTION...]\n"
    "Foveation error, from the synthetic observer's true gaze to the direction rendered for.\n"
    "  --seconds N        observed time; default 600\n"
    "  --noise DEG        of the tracker, rms from sample to sample (an axis deviates by half); default 0.3\n"
    "  --seed N           default 1\n"
    "  --plot FILE.svg    error around saccades, drawn by gnuplot\n"
    "  --json             one JSON object instead of the tables\n";

static bool parse(int count, char **arguments, struct setup *out)
{
    const struct bench_option option[] = {
        {"seconds", BENCH_DOUBLE, &out->seconds, 1, 10, 36000},
        {"noise", BENCH_DOUBLE, &out->noise_deg, 1, 0, 5},
        {"seed", BENCH_INT, &out->seed, 1, 0, INT_MAX},
        {"plot", BENCH_TEXT, &out->plot, 1, 0, 0},
        {0},
    };
    *out = (struct setup){.seed = 1, .seconds = 600, .noise_deg = 0.3};
    return bench_options(count, arguments, help, option, NULL, &out->json);
}

/* --- the observer --- */

static void take_truth(struct world *world, const struct trk_truth *truth, double t_s)
{
    struct tick *tick = &world->tick[world->ticks];
    if (truth->is_saccade && truth->saccade_number != world->saccades) {
        world->saccades = truth->saccade_number;
        world->saccade[world->saccades] = (struct saccade){
            .onset_s = truth->onset_s, .end_s = truth->end_s, .amplitude_deg = truth->amplitude_deg};
    }
    const struct saccade *last = &world->saccade[world->saccades];
    *tick = (struct tick){.hidden = truth->is_hidden,
                          .is_saccade = t_s >= last->onset_s && t_s < last->end_s,
                          .since_end_s = (float)(t_s - last->end_s),
                          .saccade = (uint32_t)world->saccades};
    memcpy(tick->direction, truth->direction, sizeof tick->direction);
}

/* Look from 100 ms before the onset, when noise and rest are measured, to 30 ms after the end. */
static void mark_hidden(struct world *world)
{
    for (size_t i = 1; i <= world->saccades; i++) {
        struct saccade *s = &world->saccade[i];
        size_t from = (size_t)(fmax(s->onset_s - 0.1, 0) * RATE_HZ * OVERSAMPLE);
        size_t to = (size_t)((s->end_s + 0.03) * RATE_HZ * OVERSAMPLE);
        if (to >= world->ticks) s->hidden = true;
        for (size_t k = from; k <= to && k < world->ticks; k++) s->hidden |= world->tick[k].hidden;
    }
}

static bool observe(const struct setup *setup, struct world *world)
{
    const size_t ticks = (size_t)(setup->seconds * RATE_HZ) * OVERSAMPLE;
    *world = (struct world){0};
    world->tick = calloc(ticks, sizeof *world->tick);
    world->saccade = calloc(ticks + 2, sizeof *world->saccade);
    world->sample = calloc(ticks / OVERSAMPLE, sizeof *world->sample);
    if (!world->tick || !world->saccade || !world->sample) return false;
    world->saccade[0] = (struct saccade){.onset_s = -1, .end_s = -1};
    struct trk_observer observer;
    trk_observer_init_with(&observer, (uint64_t)setup->seed, RATE_HZ * OVERSAMPLE, setup->noise_deg, 0);
    for (; world->ticks < ticks; world->ticks++) {
        struct trk_sample sample;
        struct trk_truth truth;
        trk_observer_next(&observer, &sample);
        trk_observer_truth(&observer, &truth);
        take_truth(world, &truth, (double)world->ticks / (RATE_HZ * OVERSAMPLE));
        if (world->ticks % OVERSAMPLE) continue;
        sample.sequence = world->samples + 1;
        world->sample[world->samples++] = sample;
    }
    mark_hidden(world);
    for (int w = 0; w < WAYS; w++) {
        struct trk_attention *attention = trk_attention_create(&way_options[w]);
        world->gaze[w] = calloc(world->samples, sizeof *world->gaze[w]);
        if (!attention || !world->gaze[w]) return trk_attention_destroy(attention), false;
        for (size_t i = 0; i < world->samples; i++)
            trk_attend(attention, &world->sample[i], world->sample[i].arrival_ns, &world->gaze[w][i]);
        trk_attention_destroy(attention);
    }
    return true;
}

static void forget(struct world *world)
{
    free(world->tick);
    free(world->saccade);
    free(world->sample);
    for (int w = 0; w < WAYS; w++) free(world->gaze[w]);
}

/* --- measures --- */

static double angle_deg(const float a[3], const float b[3])
{
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    return atan2(sqrt(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 180 / M_PI;
}

static int ascending(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Sorts the values. */
static double quantile(float *values, size_t count, double q)
{
    qsort(values, count, sizeof *values, ascending);
    return count ? values[(size_t)(q * (double)(count - 1))] : NAN;
}

/* Error at tick i of the direction that was decided one latency earlier. */
static double error_at(const struct world *world, int way, int latency, size_t i)
{
    const size_t late = (size_t)(latency_ms[latency] * RATE_HZ * OVERSAMPLE / 1000);
    const size_t sample = i < late ? 0 : (i - late) / OVERSAMPLE;
    return angle_deg(world->tick[i].direction, world->gaze[way][sample].direction);
}

static bool in_phase(const struct tick *tick, int phase)
{
    if (phase == 2) return true;
    if (tick->is_saccade || tick->since_end_s < 0) return false;
    return (tick->since_end_s < 0.1f) == (phase == 1);
}

static bool measure_errors(const struct world *world, struct result *out)
{
    float *errors = malloc(world->ticks * sizeof *errors);
    if (!errors) return false;
    for (int w = 0; w < WAYS; w++)
        for (int l = 0; l < LATENCIES; l++)
            for (int p = 0; p < PHASES; p++) {
                size_t count = 0;
                for (size_t i = RATE_HZ * OVERSAMPLE; i < world->ticks; i++)
                    if (!world->tick[i].hidden && in_phase(&world->tick[i], p))
                        errors[count++] = (float)error_at(world, w, l, i);
                out->median[w][l][p] = quantile(errors, count, 0.5);
                out->p95[w][l][p] = quantile(errors, count, 0.95);
            }
    free(errors);
    return true;
}

/* The median error at every time around the onset, over saccades that no other saccade follows in that time.
 */
static bool measure_chart(const struct world *world, struct result *out)
{
    float *errors = malloc((world->saccades + 1) * sizeof *errors);
    if (!errors) return false;
    for (int w = 0; w < WAYS; w++)
        for (int l = 0; l < LATENCIES; l++)
            for (int b = 0; b < CHART_BINS; b++) {
                size_t count = 0;
                for (size_t i = 1; i <= world->saccades; i++) {
                    const struct saccade *s = &world->saccade[i];
                    double t_s = s->onset_s + (CHART_FROM_MS + (b + 0.5) * CHART_STEP_MS) * 1e-3;
                    double next_s = i < world->saccades ? s[1].onset_s : INFINITY;
                    if (s->hidden || s->amplitude_deg < chart_amplitude_deg || t_s < s[-1].end_s + 0.1 ||
                        t_s >= next_s)
                        continue;
                    size_t tick = (size_t)(t_s * RATE_HZ * OVERSAMPLE);
                    if (tick < world->ticks && !world->tick[tick].hidden)
                        errors[count++] = (float)error_at(world, w, l, tick);
                }
                out->chart[w][l][b] = quantile(errors, count, 0.5);
            }
    free(errors);
    return true;
}

static int class_of(double amplitude_deg)
{
    int k = 0;
    while (k + 1 < AMPLITUDES && amplitude_deg >= amplitude_from[k + 1]) k++;
    return k;
}

/* Each onset that is reported with the filter on belongs to the saccade that is under way, or is a false
 * alarm. It may come one sample before the true onset, when noise helps, and for the smallest saccades up to
 * three samples after the end. */
static void measure_onsets(const struct world *world, struct result *out)
{
    const struct trk_aim *gaze = world->gaze[1];
    int *late = calloc(world->saccades + 2, sizeof *late); /* 1 + samples, 0: not found */
    size_t false_alarms = 0, seen = 0;
    if (!late) return;
    for (size_t k = RATE_HZ; k < world->samples; k++) {
        const double t_s = (double)k / RATE_HZ;
        seen += !world->tick[k * OVERSAMPLE].hidden;
        if (gaze[k].state != TRK_SACCADE || gaze[k - 1].state == TRK_SACCADE) continue;
        size_t i = world->tick[k * OVERSAMPLE].saccade;
        if (i < world->saccades && t_s >= world->saccade[i + 1].onset_s - 1.0 / RATE_HZ) i++;
        const struct saccade *s = &world->saccade[i];
        double first = ceil(s->onset_s * RATE_HZ - 1e-9);
        if (i && t_s >= s->onset_s - 1.0 / RATE_HZ && t_s <= s->end_s + 3.0 / RATE_HZ) {
            if (!late[i]) late[i] = 1 + (int)fmax((double)k - first, 0);
        } else if (!i || !s->hidden || t_s > s->end_s + 0.5) {
            false_alarms++;
        }
    }
    for (size_t i = 1; i <= world->saccades; i++) {
        const struct saccade *s = &world->saccade[i];
        if (s->hidden || s->onset_s < 1) continue;
        struct onset *onset = &out->onset[class_of(s->amplitude_deg)];
        onset->count++;
        if (late[i])
            onset->late[late[i] <= MAX_LATE ? late[i] - 1 : MAX_LATE - 1]++;
        else
            onset->missed++;
    }
    out->false_per_minute = (double)false_alarms / ((double)seen / RATE_HZ / 60);
    out->noise_deg = 2 * gaze[world->samples - 1].noise_deg;
    free(late);
}

static double within(const struct onset *onset, int samples)
{
    int sum = 0;
    for (int i = 0; i <= samples && i < MAX_LATE; i++) sum += onset->late[i];
    return onset->count ? (double)sum / onset->count : NAN;
}

/* The share of onsets found within two samples, among saccades that are not microsaccades. */
static double within_bar(const struct result *result)
{
    double count = 0, found = 0;
    for (int k = 0; k < AMPLITUDES; k++) {
        const struct onset *onset = &result->onset[k];
        if (amplitude_from[k] < seen_deg || !onset->count) continue;
        count += onset->count;
        found += onset->count * within(onset, 2);
    }
    return found / count;
}

/* --- output --- */

static void print_tables(const struct setup *setup, const struct result *result)
{
    printf("synthetic observer, %.0f s at %d Hz, noise %g degrees rms from sample to sample (measured "
           "%.2f), no bias\n\nonset of saccades\n%-14s %7s %10s %10s %10s %8s\n",
           setup->seconds, RATE_HZ, setup->noise_deg, result->noise_deg, "amplitude", "count", "1 sample",
           "2 samples", "3 samples", "missed");
    for (int k = 0; k < AMPLITUDES; k++) {
        const struct onset *onset = &result->onset[k];
        printf("%4g to %2g deg   %7d %8.1f %% %8.1f %% %8.1f %% %6.1f %%\n", amplitude_from[k],
               fmin(amplitude_from[k + 1], 30), onset->count, 100 * within(onset, 1), 100 * within(onset, 2),
               100 * within(onset, 3), 100.0 * onset->missed / (onset->count ? onset->count : 1));
    }
    printf("%g degrees and more: %.1f %% within 2 samples (aim: 95 %%); false alarms a minute: "
           "%.2f\n\nfoveation error, degrees: median, 95th percentile\n%-14s %8s",
           seen_deg, 100 * within_bar(result), result->false_per_minute, "", "latency");
    for (int p = 0; p < PHASES; p++) printf(" %22s", phase_names[p]);
    putchar('\n');
    for (int w = 0; w < WAYS; w++)
        for (int l = 0; l < LATENCIES; l++) {
            printf("%-14s %5d ms", l ? "" : way_names[w], latency_ms[l]);
            for (int p = 0; p < PHASES; p++)
                printf("         %6.2f %6.2f", result->median[w][l][p], result->p95[w][l][p]);
            putchar('\n');
        }
}

static void print_json(const struct setup *setup, const struct result *result)
{
    json_t *onsets = json_array(), *errors = json_array();
    for (int k = 0; k < AMPLITUDES; k++) {
        const struct onset *onset = &result->onset[k];
        if (onset->count)
            json_array_append_new(onsets,
                                  json_pack("{s:f,s:f,s:i,s:f,s:f,s:f}", "from_deg", amplitude_from[k],
                                            "to_deg", fmin(amplitude_from[k + 1], 30), "count", onset->count,
                                            "within_1", within(onset, 1), "within_2", within(onset, 2),
                                            "missed", (double)onset->missed / onset->count));
    }
    for (int w = 0; w < WAYS; w++)
        for (int l = 0; l < LATENCIES; l++)
            for (int p = 0; p < PHASES; p++)
                json_array_append_new(errors,
                                      json_pack("{s:s,s:i,s:s,s:f,s:f}", "way", way_names[w], "latency_ms",
                                                latency_ms[l], "phase", phase_names[p], "median_deg",
                                                result->median[w][l][p], "p95_deg", result->p95[w][l][p]));
    json_t *root = json_pack("{s:f,s:i,s:f,s:f,s:f,s:f,s:o,s:o}", "seconds", setup->seconds, "rate_hz",
                             RATE_HZ, "noise_deg", setup->noise_deg, "seen_from_deg", seen_deg,
                             "seen_within_2", within_bar(result), "false_alarms_per_minute",
                             result->false_per_minute, "onsets", onsets, "errors", errors);
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(5));
    putchar('\n');
    json_decref(root);
}

static bool plot(const struct setup *setup, const struct result *result)
{
    static const char *const colours[WAYS] = {"#999999", "#0072b2", "#d55e00"};
    char error[DMN_FILE_ERROR_SIZE];
    struct dmn_chart chart;
    if (!dmn_chart_begin(&chart, error)) return bench_fail(error);
    FILE *gnuplot = chart.commands;
    fprintf(gnuplot,
            "set terminal svg size 1000,720 font 'sans,14' background 'white'\n"
            "set multiplot layout 2,2 title \"Foveation error around saccades of 5 to 30 degrees\\n"
            "{/*0.8 tracker at %d Hz, noise %g degrees; medians}\"\n"
            "set grid\nset xrange [%d:%d]\nset yrange [0.05:20]\nset logscale y\nset xtics 50\n"
            "set arrow 1 from 0,graph 0 to 0,graph 1 nohead dashtype 3\n",
            RATE_HZ, setup->noise_deg, CHART_FROM_MS, CHART_TO_MS);
    for (int l = 0; l < LATENCIES; l++) {
        fprintf(gnuplot, "set title 'latency %d ms'\n%s\nset xlabel '%s'\nset ylabel '%s'\nplot ",
                latency_ms[l], l == 0 ? "set key top right" : "unset key",
                l >= 2 ? "time since the onset, ms" : "", l % 2 ? "" : "error, degrees");
        for (int w = 0; w < WAYS; w++)
            fprintf(gnuplot, "%s'-' with lines linewidth 2 linecolor '%s' title '%s'", w ? ", " : "",
                    colours[w], way_names[w]);
        fputc('\n', gnuplot);
        for (int w = 0; w < WAYS; w++) {
            for (int b = 0; b < CHART_BINS; b++)
                fprintf(gnuplot, "%g %g\n", CHART_FROM_MS + (b + 0.5) * CHART_STEP_MS,
                        result->chart[w][l][b]);
            fputs("e\n", gnuplot);
        }
    }
    fputs("unset multiplot\n", gnuplot);
    return dmn_chart_end(&chart, setup->plot, 0666, error) || bench_fail(error);
}

int bench_foveation(int count, char **arguments)
{
    struct setup setup;
    static struct world world;
    static struct result result;
    if (!parse(count, arguments, &setup)) return 2;
    bool ok = observe(&setup, &world) && measure_errors(&world, &result) &&
              (!setup.plot || measure_chart(&world, &result));
    if (ok) measure_onsets(&world, &result);
    if (!ok) fprintf(stderr, "fovea-bench: no memory for %g s\n", setup.seconds);
    if (ok) (setup.json ? print_json : print_tables)(&setup, &result);
    if (ok && setup.plot) ok = plot(&setup, &result);
    forget(&world);
    return ok ? 0 : 1;
}
