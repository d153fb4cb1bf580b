/* foveactl gaze plot: a gaze log as a chart, drawn by gnuplot: yaw and pitch over time with what the eye did,
 * and the path of gaze over an equirectangular picture's frame. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "chart.h"
#include "ctl.h"
#include "tracker.h"

/* As many points as a chart of this width can show. Of longer logs, samples are drawn at equal steps. */
enum { MOST_POINTS = 20000, MOST_BANDS = 2000 };

static const char SETUP[] =
    "set encoding utf8\n"
    "set style line 1 lc rgb '#4477aa' lw 1.2\n" /* Paul Tol's bright scheme: safe for colour-blind eyes */
    "set style line 2 lc rgb '#ee6677' lw 1.6\n"
    "set style line 3 lc rgb '#228833' lw 1.6\n"
    "set style line 4 lc rgb '#aaaaaa' lw 0.7\n"
    "set style line 5 lc rgb '#bbbbbb'\n"
    "set border lc rgb '#666666'\n"
    "set grid lc rgb '#e4e4e4' lt 1\n"
    "set tics nomirror\n";

double ctl_yaw_deg(const float v[3])
{
    return atan2((double)v[0], -(double)v[2]) * 180 / M_PI;
}

double ctl_pitch_deg(const float v[3])
{
    return asin(fmin(fmax((double)v[1], -1), 1)) * 180 / M_PI;
}

/* Write a text in gnuplot's single quotes. */
static void put_quoted(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++) {
        if (*text == '\'') fputc('\'', out);
        fputc(iscntrl((unsigned char)*text) ? '?' : *text, out);
    }
    fputc('\'', out);
}

static double seconds(const struct trk_log *log, uint64_t time_ns)
{
    return (double)(time_ns - trk_log_time(log, 0)) / 1e9;
}

static bool world_direction(const struct trk_log *log, size_t i, float out_direction[3])
{
    struct trk_sample sample;

    trk_log_sample(log, i, &sample);
    return trk_world_direction(&sample, out_direction);
}

/* Is there a gap in the steps after sample first, up to last? */
static bool is_gap_between(const struct trk_log *log, const struct trk_rate *rate, size_t first, size_t last)
{
    for (size_t i = first + 1; i <= last && i < log->count; i++)
        if (trk_log_is_gap(log, rate, i)) return true;
    return false;
}

/* Write the samples of events of one type, or of all (-1): time, yaw, pitch. An empty line separates them
 * where gaze is lost or passes behind the viewer, and at gaps. */
static void put_path(FILE *out, const char *name, const struct trk_log *log, const struct trk_rate *rate,
                     const struct trk_events *events, int type)
{
    size_t step = 1 + log->count / MOST_POINTS, event = 0;
    double last_yaw = NAN;

    fprintf(out, "$%s << EOD\n", name);
    for (size_t i = 0; i < log->count; i += step) {
        float world[3];
        bool is_here;

        if (!isnan(last_yaw) && is_gap_between(log, rate, i - step, i)) {
            fputc('\n', out);
            last_yaw = NAN;
        }
        while (event < events->count && events->events[event].last < i) event++;
        is_here = event < events->count && events->events[event].first <= i &&
                  (int)events->events[event].type == type;
        if ((type >= 0 && !is_here) || !world_direction(log, i, world)) {
            if (!isnan(last_yaw)) fputc('\n', out);
            last_yaw = NAN;
            continue;
        }
        if (fabs(ctl_yaw_deg(world) - last_yaw) > 180) fputc('\n', out);
        last_yaw = ctl_yaw_deg(world);
        fprintf(out, "%.4f %.3f %.3f\n", seconds(log, trk_log_time(log, i)), last_yaw, ctl_pitch_deg(world));
    }
    fputs("EOD\n", out);
}

/* Write the times of blinks and losses. One outside the chart keeps the block from being empty. */
static void put_bands(FILE *out, const struct trk_log *log, const struct trk_events *events)
{
    int count = 0;

    fputs("$unseen << EOD\n-2 -400 -1 -400\n", out);
    for (size_t i = 0; i < events->count && count < MOST_BANDS; i++) {
        const struct trk_event *e = &events->events[i];

        if (e->type != TRK_BLINK && e->type != TRK_LOST) continue;
        fprintf(out, "%.4f -400 %.4f 400\n", seconds(log, e->start_ns), seconds(log, e->end_ns));
        count++;
    }
    fputs("EOD\n", out);
}

/* Write fixations: yaw, pitch, radius by duration, time. */
static void put_fixations(FILE *out, const struct trk_log *log, const struct trk_events *events)
{
    fputs("$fixations << EOD\n-400 -400 0.1 0\n", out);
    for (size_t i = 0, n = 0; i < events->count && n < MOST_POINTS; i++) {
        const struct trk_event *e = &events->events[i];

        if (e->type != TRK_FIXATION) continue;
        n++;
        fprintf(out, "%.3f %.3f %.3f %.4f\n", ctl_yaw_deg(e->direction), ctl_pitch_deg(e->direction),
                fmin(6, 2 * sqrt((double)(e->end_ns - e->start_ns) / 1e9)), seconds(log, e->start_ns));
    }
    fputs("EOD\n", out);
}

/* The range of an angle over the log, with a margin. */
static void range_of(const struct trk_log *log, double (*angle)(const float v[3]), double out_range[2])
{
    double low = INFINITY, high = -INFINITY;

    for (size_t i = 0; i < log->count; i++) {
        float world[3];

        if (!world_direction(log, i, world)) continue;
        low = fmin(low, angle(world));
        high = fmax(high, angle(world));
    }
    if (low > high) low = high = 0;
    out_range[0] = low - 0.06 * (high - low) - 0.5;
    out_range[1] = high + 0.06 * (high - low) + 0.5;
}

static void put_time_chart(FILE *out, const char *label, int column, const double range[2], bool with_key)
{
    static const struct {
        const char *block, *title;
        int style;
    } lines[] = {{"other", "other", 4},
                 {"fixation", "fixation", 1},
                 {"pursuit", "pursuit", 3},
                 {"saccade", "saccade", 2}};

    fprintf(out, "set ylabel '%s'\nset yrange [%.3f:%.3f]\n%s\n", label, range[0], range[1],
            with_key ? "set key top outside right horizontal samplen 2" : "unset key");
    fputs("plot $unseen using (($1+$3)/2):(0):1:3:2:4 with boxxyerror fs solid 0.35 noborder ls 5 title "
          "'blink or loss'",
          out);
    for (size_t i = 0; i < sizeof(lines) / sizeof(*lines); i++)
        fprintf(out, ", $%s using 1:%d with lines ls %d title '%s'", lines[i].block, column, lines[i].style,
                lines[i].title);
    fputc('\n', out);
}

static void put_charts(FILE *out, const char *path, const struct trk_log *log)
{
    double yaw[2], pitch[2], end_s = seconds(log, trk_log_time(log, log->count - 1));

    range_of(log, ctl_yaw_deg, yaw);
    range_of(log, ctl_pitch_deg, pitch);
    fputs("set multiplot\nset title ", out);
    put_quoted(out, path);
    fprintf(out,
            " noenhanced left\nset lmargin at screen 0.07\nset rmargin at screen 0.90\nset tmargin at screen "
            "0.94\n"
            "set bmargin at screen 0.74\nset xrange [0:%.4f]\nset format x ''\n",
            end_s > 0 ? end_s : 1);
    put_time_chart(out, "yaw, degrees", 2, yaw, true);
    fputs("unset title\nset tmargin at screen 0.72\nset bmargin at screen 0.56\nset format x '%g'\n"
          "set xlabel 'seconds' offset 0,0.6\n",
          out);
    put_time_chart(out, "pitch, degrees", 3, pitch, false);
    fprintf(
        out,
        "set tmargin at screen 0.48\nset bmargin at screen 0.06\nset xrange [-180:180]\nset yrange [-90:90]\n"
        "set xtics 30\nset ytics 30\nset xlabel 'yaw, degrees to the right' offset 0,0.6\n"
        "set ylabel 'pitch, degrees up'\nset cblabel 'seconds' offset -0.5,0\nset cbrange [0:%.4f]\nset "
        "palette defined (0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725')\n"
        "set style fill transparent solid 0.6 noborder\n"
        "plot $path using 2:3 with lines ls 4 notitle, "
        "$fixations using 1:2:3:4 with circles lc palette notitle\nunset multiplot\n",
        end_s > 0 ? end_s : 1);
}

/* Draw the chart. False after a line on stderr. */
static bool draw(const char *path, const char *out_path, const struct trk_log *log,
                 const struct trk_rate *rate, const struct trk_events *events)
{
    bool is_png = ctl_ends_with(out_path, ".png");
    char error[DMN_FILE_ERROR_SIZE];
    struct dmn_chart chart;
    FILE *out;

    if (!dmn_chart_begin(&chart, error)) return ctl_fail("%s", error);
    out = chart.commands;
    fprintf(out, "set terminal %s size 1200,1200 font 'sans,%d' %s\n", is_png ? "pngcairo" : "svg",
            is_png ? 11 : 14, is_png ? "" : "background rgb 'white'");
    fputs(SETUP, out);
    put_bands(out, log, events);
    put_fixations(out, log, events);
    put_path(out, "path", log, rate, events, -1);
    put_path(out, "other", log, rate, events, -1);
    put_path(out, "fixation", log, rate, events, TRK_FIXATION);
    put_path(out, "pursuit", log, rate, events, TRK_PURSUIT);
    put_path(out, "saccade", log, rate, events, TRK_SACCADE);
    put_charts(out, path, log);
    return dmn_chart_end(&chart, out_path, 0600, error) || ctl_fail("%s", error);
}

static int run(const struct ctl *ctl)
{
    const char *out = ctl->operand[1];
    struct trk_log log;
    struct trk_events events;
    struct trk_rate rate;
    bool good = false;

    if (!ctl_ends_with(out, ".svg") && !ctl_ends_with(out, ".png"))
        return ctl_fail("%s: expected a name that ends with .svg or .png", out), 2;
    if (!ctl_read_log(ctl, &log)) return 1;
    if (trk_log_is_from(&log, out)) {
        ctl_fail("%s: is the log itself, or a file that it was read with; expected another name", out);
    } else if (trk_events_find(&log, &events)) {
        trk_log_rate(&log, &rate);
        good = draw(ctl->operand[0], out, &log, &rate, &events);
        trk_events_finish(&events);
    } else {
        ctl_fail("out of memory");
    }
    if (good) dmn_print(stdout, "%s: %zu samples of %s\n", out, log.count, log.format);
    if (good && *log.assumed) dmn_print(stdout, "assumed: %s\n", log.assumed);
    trk_log_finish(&log);
    return good ? 0 : 1;
}

const struct ctl_command ctl_gaze_plot = {
    .name = "gaze plot",
    .operands = "LOG OUT",
    .summary = "chart a gaze log as OUT, .svg or .png: yaw and pitch over time, path of gaze",
    .options = CTL_LOG,
    .run = run,
};
