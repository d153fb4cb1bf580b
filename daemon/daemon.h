/* daemon: the programs fovead and foveactl. This header has what both share and what decides without doing:
 * command lines, when a render is done, what a client is sent next, latency histograms. All of it is tested
 * without a socket and without a ray.
 *
 * How fovead runs
 * - One thread has the event loop (loop.c): sockets, timers, sessions. It alone encodes and sends.
 * - One thread paints (paint.c): batch after batch, aimed at the newest gaze; the renderer has its own
 * workers.
 * - With the real clock one thread reads the gaze source (gaze.c). With the virtual clock the painter reads
 * it, so that the same log gives the same film.
 * - One thread writes files that clients asked for (saver.c).
 * The others wake the loop; the loop never waits for them.
 */
#ifndef FOVEAD_DAEMON_H
#define FOVEAD_DAEMON_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "protocol.h"
#include "renderer.h"
#include "tracker.h"

enum {
    DMN_MAX_LISTEN = 8,
    DMN_MAX_LEVELS = 16,
    DMN_OUTLINE_PATHS = 16,  /* paths that rnd_render_outline() leaves in a tile of the film */
    DMN_FARTHEST = 10000000, /* m, of the eye from the origin along each axis: beyond, floats skip metres */
};

/* What clients are told of the scene. */
struct dmn_scene_words {
    char line[1024];
    char refused[RND_ERROR_SIZE]; /* why the last edit was not taken; "": it was */
};

/* --- text for people
 * ----------------------------------------------------------------------------------------------------- */

/* As fprintf(), but control characters other than line ends become blanks: names come from files, devices and
 * peers, and must not drive a terminal. */
void dmn_print(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
void dmn_vprint(FILE *out, const char *format, va_list arguments);

/* --- numbers and directions
 * ---------------------------------------------------------------------------------- */

/* CLOCK_MONOTONIC. */
uint64_t dmn_now_ns(void);

/* Exactly count finite numbers with commas between them and nothing else. */
bool dmn_parse_numbers(const char *text, int count, double *out_numbers);
/* A whole number from low to high. */
bool dmn_parse_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out_number);
/* "WxH"; *out_height is 0 if only "W" was given. Both from 1 to 65536. */
bool dmn_parse_size(const char *text, int *out_width, int *out_height);

/* Is it a place where the eye can be? */
bool dmn_eye_is_somewhere(const double eye[3]);

/* Azimuth (right of -Z) and elevation, deg. */
void dmn_angles(const float direction[3], double *out_yaw_deg, double *out_pitch_deg);
/* A view whose middle is direction and whose up is up: x y z w, view to world. */
void dmn_orientation(const float direction[3], float out_orientation[4]);

/* --- when a render is done
 * ----------------------------------------------------------------------------------- */

enum dmn_until_kind {
    DMN_UNTIL_STOPPED,
    DMN_UNTIL_PATHS,
    DMN_UNTIL_SECONDS,
    DMN_UNTIL_CONVERGED,
    DMN_UNTIL_END
};

struct dmn_until {
    enum dmn_until_kind kind;
    double amount; /* paths a film pixel, or seconds of rendering */
};

struct dmn_progress {
    uint64_t paths, pixels;
    double seconds;
    uint32_t tiles, converged;
    bool gaze_ended;
};

/* "256spp", "30s", "converged" or "end". */
bool dmn_until_parse(const char *text, struct dmn_until *out_until);
/* 0 to 1; exactly 1 when the render is done. */
double dmn_until_share(const struct dmn_until *until, const struct dmn_progress *progress);

/* --- fovead's command line
 * ----------------------------------------------------------------------------------- */

struct dmn_options {
    struct rnd_scene_options scene;
    bool watch; /* take up edits of the scene's files */
    struct rnd_render_options render;
    const char *gaze; /* NULL: no source; samples are not steered */
    double speed;
    bool loop;
    bool raw_gaze, predict;
    struct trk_screen screen;
    const char *calibration; /* NULL: none */
    const char *record;      /* NULL: not recorded */
    bool replace;            /* what record names may exist */
    float fov[2];            /* rad, of the vp viewport */
    float display_ppd;       /* pixels per degree; 0: as fine as the eye */
    bool virtual_clock;
    struct pro_address listen[DMN_MAX_LISTEN];
    int listens;
    struct dmn_until until;
    const char *save; /* NULL: not saved */
    bool json;
};

enum dmn_parsed { DMN_RUN, DMN_LIST, DMN_ANSWERED, DMN_REFUSED };

/* Strings in *out_options point into argv. DMN_LIST: only list eye trackers. DMN_ANSWERED after --help or
 * --version (exit 0), DMN_REFUSED after one line on stderr (exit 2). */
enum dmn_parsed dmn_options_parse(int argc, char **argv, struct dmn_options *out_options);

/* --- what a client is sent next
 * ------------------------------------------------------------------------------ */

/* What is known of a tile at any level. */
struct dmn_state {
    uint64_t samples;
    bool converged, settled;
};

struct dmn_level {
    int columns, rows;
    size_t first; /* index of its first tile */
};

/* The film's tiles at every level, finest first, row by row. */
struct dmn_pyramid {
    int levels;
    struct dmn_level level[DMN_MAX_LEVELS];
    size_t count;            /* tiles of all levels */
    struct dmn_state *state; /* count of them */
    float (*centre)[3];      /* directions of their middles */
    bool *stale;             /* those whose sums dmn_pyramid_update() has to make anew */
};

/* levels as rnd_render_levels() gives it. False if memory is short. */
bool dmn_pyramid_init(struct dmn_pyramid *pyramid, int width, int height, int levels);
void dmn_pyramid_finish(struct dmn_pyramid *pyramid);
/* Set the states of level-0 tiles, then sum up the changed ones level by level. */
void dmn_pyramid_set(struct dmn_pyramid *pyramid, size_t index, const struct dmn_state *state);
void dmn_pyramid_update(struct dmn_pyramid *pyramid);

struct dmn_place {
    int level, x, y;
    size_t index; /* in the pyramid */
    float rank;   /* lower goes first */
};

/* The tiles that a client should be sent next, best first, at most limit of them; returns how many.
 * sent (pyramid->count of them) says what each tile was when it was last sent to this client; samples 0 if
 * never.
 *  1. What has no picture at all yet, coarsest level first, so that nothing stays black.
 *  2. The other coarse levels, the whole sphere.
 *  3. By distance from gaze: finer tiles where the mean pixel has a path or more, and tiles sent before that
 * have half as many paths again, or have converged or settled since. A tile that finer ones hide, or could
 * replace at once, is not sent again. */
size_t dmn_next(const struct dmn_pyramid *pyramid, const struct dmn_state *sent, const float gaze[3],
                size_t limit, struct dmn_place *out_places);

/* The tile of level 0 that the gaze falls into. */
size_t dmn_pyramid_at(const struct dmn_pyramid *pyramid, const float gaze[3]);
/* The tile by which the client sees that place: the finest that it was sent. False if that has nothing new.
 */
bool dmn_seen_at(const struct dmn_pyramid *pyramid, const struct dmn_state *sent, const float gaze[3],
                 struct dmn_place *out_place);

/* --- latency
 * ------------------------------------------------------------------------------------------------- */

/* Times in bins of two per cent, from a microsecond to two hours. All zero is empty. */
struct dmn_histogram {
    uint64_t count;
    uint32_t bin[1088];
};

void dmn_histogram_add(struct dmn_histogram *histogram, double seconds);
/* The time below which share (0 to 1) of them lie; 0 when empty. */
double dmn_histogram_quantile(const struct dmn_histogram *histogram, double share);

#endif
