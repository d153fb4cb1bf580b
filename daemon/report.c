/* What fovead tells people and scripts. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <jansson.h>

#include "report.h"

static const uint64_t LINE_EVERY_NS = 3000000000;
enum { BAR = 32 };

void dmn_report_scene(const struct rnd_scene_info *info, const char *path, char *out_line, size_t size)
{
    char textures[32] = "";

    if (info->texture_bytes)
        snprintf(textures, sizeof(textures), " (%.1f MB)", (double)info->texture_bytes * 1e-6);
    snprintf(
        out_line, size,
        "%s: %llu triangles (%llu emissive), %u materials, %u textures%s, %u lights%s%s; read in %.2f s, "
        "built in %.2f s",
        path, (unsigned long long)info->triangles, (unsigned long long)info->emissive_triangles,
        info->materials, info->textures, textures, info->punctual_lights,
        info->has_env ? ", environment" : "", info->has_sun ? ", sun" : "", info->read_seconds,
        info->build_seconds);
    rnd_make_printable(out_line);
}

void dmn_report_warnings(const char *lines)
{
    for (size_t length; *lines; lines += length + 1) {
        length = strcspn(lines, "\n");
        dmn_print(stderr, "fovead: warning: %.*s\n", (int)length, lines);
    }
}

void dmn_report_left_out(const struct rnd_scene_info *info, const char *path)
{
    dmn_report_warnings(info->warnings);
    if (*info->unsupported)
        dmn_print(stderr, "fovead: %s asks for what is left out here: %s\n", path, info->unsupported);
}

/* Seconds as people read them. */
static void print_time(double seconds, char *out, size_t size)
{
    if (!(seconds < 360000))
        snprintf(out, size, "-");
    else if (seconds < 100)
        snprintf(out, size, "%.0f s", seconds);
    else if (seconds < 6000)
        snprintf(out, size, "%d:%02d min", (int)(seconds / 60), (int)seconds % 60);
    else
        snprintf(out, size, "%d:%02d h", (int)(seconds / 3600), (int)(seconds / 60) % 60);
}

void dmn_report_progress(struct dmn_bar *bar, const struct dmn_options *options, const struct dmn_work *work)
{
    bool terminal = isatty(STDERR_FILENO);
    uint64_t now_ns = dmn_now_ns();
    char share[8], spent[24], left[24], line[200];
    double paths = (double)work->paths / ((double)options->render.width * options->render.height);

    if (options->until.kind == DMN_UNTIL_STOPPED) return;
    if (!bar->printed_ns) bar->printed_ns = now_ns;
    if (!terminal && now_ns - bar->printed_ns < LINE_EVERY_NS) return;
    bar->printed_ns = now_ns;
    print_time(work->seconds, spent, sizeof(spent));
    /* When a picture converges, or how long a log is, is not known. */
    if (options->until.kind == DMN_UNTIL_PATHS || options->until.kind == DMN_UNTIL_SECONDS)
        print_time(work->seconds / work->share - work->seconds, left, sizeof(left));
    else
        snprintf(left, sizeof(left), "?");
    if (options->until.kind == DMN_UNTIL_END)
        snprintf(share, sizeof(share), "  -");
    else
        snprintf(share, sizeof(share), "%3.0f", floor(work->share * 100));
    snprintf(line, sizeof(line), "%s %%  %.4g paths/px  %.2f Mpaths/s  %s, %s left", share, paths,
             work->paths_per_second * 1e-6, spent, left);
    if (terminal) {
        int full = (int)(work->share * BAR);

        fprintf(stderr, "\r\033[K[%.*s%.*s] %s", full, "################################", BAR - full,
                "................................", line);
        bar->drawn = true;
    } else {
        fprintf(stderr, "fovead: %s\n", line);
    }
}

void dmn_report_progress_end(struct dmn_bar *bar)
{
    if (bar->drawn) fputc('\n', stderr);
    bar->drawn = false;
}

static void print_table(const struct dmn_options *options, const struct dmn_picture *picture,
                        const struct dmn_work *work, const struct dmn_gaze_status *gaze, bool saved)
{
    double pixels = (double)options->render.width * options->render.height;

    printf("paths        %llu (%.4g a pixel of %dx%d), %llu rays, by %s\n", (unsigned long long)work->paths,
           (double)work->paths / pixels, options->render.width, options->render.height,
           (unsigned long long)work->rays, options->render.distribution->name);
    printf("time         %.2f s, %.3f Mpaths/s\n", work->seconds,
           work->seconds > 0 ? (double)work->paths / work->seconds * 1e-6 : 0);
    printf("tiles        %u: %u visited, %u converged, %u settled\n", picture->tiles, picture->visited,
           picture->converged, picture->settled);
    if (options->gaze)
        printf("gaze         %llu samples, %llu valid\n", (unsigned long long)gaze->samples,
               (unsigned long long)gaze->valid);
    if (work->not_finite) printf("not finite   %llu paths left out\n", (unsigned long long)work->not_finite);
    if (saved) dmn_print(stdout, "saved        %s\n", options->save);
}

static void print_json(const struct dmn_options *options, const struct dmn_picture *picture,
                       const struct dmn_work *work, const struct dmn_gaze_status *gaze, bool saved)
{
    json_t *object = json_pack(
        "{s:s, s:s, s:s, s:[i,i], s:I, s:I, s:I, s:f, s:f, s:I, s:i, s:i, s:i, s:i, s:I, s:I, s:s?}", "scene",
        options->scene.path, "gaze", gaze->source.description, "mode", options->render.distribution->name,
        "size", options->render.width, options->render.height, "paths", (json_int_t)work->paths, "rays",
        (json_int_t)work->rays, "batches", (json_int_t)work->batches, "seconds", work->seconds,
        "paths_per_second", work->seconds > 0 ? (double)work->paths / work->seconds : 0.0, "not_finite",
        (json_int_t)work->not_finite, "tiles", (int)picture->tiles, "tiles_visited", (int)picture->visited,
        "tiles_converged", (int)picture->converged, "tiles_settled", (int)picture->settled, "gaze_samples",
        (json_int_t)gaze->samples, "gaze_valid", (json_int_t)gaze->valid, "saved",
        saved ? options->save : NULL);

    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

void dmn_report_summary(const struct dmn_options *options, const struct dmn_picture *picture,
                        const struct dmn_work *work, const struct dmn_gaze_status *gaze, bool saved)
{
    (options->json ? print_json : print_table)(options, picture, work, gaze, saved);
    fflush(stdout);
}

void dmn_report_recording(struct dmn_told *told, const struct dmn_gaze_status *gaze)
{
    struct dmn_told now = {gaze->recording_fails, gaze->lost > 0};

    if (*gaze->recording && (now.fails != told->fails || (now.lost && !told->lost)))
        dmn_print(stderr, "fovead: %s; %llu samples are lost, %s\n", gaze->recording_error,
                  (unsigned long long)gaze->lost,
                  now.fails ? "the newest wait until there is room" : "the recording goes on");
    *told = *gaze->recording ? now : (struct dmn_told){0};
}
