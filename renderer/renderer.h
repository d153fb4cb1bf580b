/* renderer: a progressive path tracer of 360-degree pictures whose samples fall where the eye can use them.
 *
 * A scene is loaded once; a render adds batches of paths to an equirectangular film, each batch placed by a
 * distribution around the newest gaze; tiles of the film can be read at any time at any level of detail. This
 * folder knows nothing of gaze devices or sockets.
 *
 * Conventions
 * - Frames follow OpenXR and glTF: right-handed, +X right, +Y up, -Z forward; metres, radians; quaternions
 * (x, y, z, w).
 * - Equirectangular: u = 1/2 + atan2(x, -z) / 2 pi, v = 1/2 - asin(y) / pi, u wraps, row 0 is up.
 * - Radiance is linear, scene-referred, Rec.709 primaries, float.
 * - Every random number is addressed by (seed, pixel, sample, dimension): the same batches give the same film
 * bit for bit, whatever the number of threads.
 * - What is rendered changes only by rnd_render_restart(), which empties the film: a new generation of it.
 * - Errors are one line of text in a caller's buffer of RND_ERROR_SIZE bytes that names the file and the
 * cause.
 */
#ifndef FOVEAD_RENDERER_H
#define FOVEAD_RENDERER_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum {
    RND_ERROR_SIZE = 512,
    RND_TILE = 64,         /* pixels a side of a tile, at every level */
    RND_MAX_WIDTH = 32768, /* of a film; the height is half of it */
};

/* --- scene --- */

struct rnd_scene;

/* Files are read by programs that lie beside this one, fovead-reader and fovead-image: a file that crashes
 * them, or has them take too much, is refused and takes nothing else with it. The second one takes a while to
 * start, serves many scenes, and writes the films of their renders. NULL if memory is short. */
struct rnd_image_program *rnd_image_program_create(void);
/* Start it, if it does not run; this does not wait until it is ready. Else it starts when a picture is
 * wanted. False and a line in out_error if it is not there. */
bool rnd_image_program_start(struct rnd_image_program *program, char out_error[RND_ERROR_SIZE]);
/* Accepts NULL. The program ends when no scene and no render has it any more either. */
void rnd_image_program_destroy(struct rnd_image_program *program);

struct rnd_scene_options {
    const char *path;     /* glTF, GLB, OBJ, or what else assimp reads */
    const char *env_path; /* equirectangular environment map, or NULL */
    bool has_sun;
    float sun[4]; /* azimuth (deg, right of -Z), elevation (deg), irradiance on a surface facing it, angular
                     diameter (deg, 0 to 90) */
    float env_azimuth; /* deg by which the environment map is turned to the right */
    /* Do not wait for the textures, but for those that say where a surface is or what it emits: the first
     * picture does without the others. See rnd_scene_take_textures(). */
    bool textures_later;
    /* Surfaces draw lights straight through glass that refracts or is a little rough (up to 0.25), weighed by
     * what the glass lets through; paths do not find them behind it by chance. Far less noise, but no
     * caustics, and sharp shadows behind rough glass. Off: unbiased. */
    bool clear_glass;
    /* Limits of the programs that read files: MiB of memory, and seconds of processor time for one file; 0:
     * the defaults of reader_limits.c. Embree's trees may take as much memory again. */
    uint32_t reader_mib, reader_seconds;
    /* Who reads pictures, ready from scenes before. NULL: a new one. */
    struct rnd_image_program *image_program;
    const atomic_bool *cancel; /* set by any thread as soon as the scene is not wanted any more; or NULL */
    bool has_eye;
    double eye[3]; /* m; without it the first camera of the file, else the middle of the scene's bounds */
};

struct rnd_scene_info {
    uint64_t triangles, emissive_triangles; /* those of a mesh that is in many places count in each */
    uint32_t meshes, materials, textures, punctual_lights;
    bool has_env, has_sun;
    double eye[3];
    double bounds[2][3];                /* lowest and highest corner, m */
    uint64_t texture_bytes;             /* 0 while they are read */
    double read_seconds, build_seconds; /* import and textures; BVH and light tables */
    const char *
        unsupported; /* what the file asks for and the renderer does not do, comma-separated; "" if nothing */
    /* The files beside its own that the scene's file names, found or not: files_bytes bytes of paths, each with
     * its NUL. They come from the file: print none as it is. */
    const char *files;
    size_t files_bytes;
    const char *warnings; /* what was mended, and images that cannot be read: lines, each with its end; "" if
                             nothing */
};

/* Load a scene. NULL and a line in out_error when the file is missing or broken, holds no triangle or a
 * vertex that is not finite, the environment map cannot be read, or nothing in it gives light. The caller
 * frees with rnd_scene_destroy(). */
struct rnd_scene *rnd_scene_load(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE]);
void rnd_scene_destroy(struct rnd_scene *scene); /* accepts NULL; after every render of it */

/* Use the textures of a scene that was loaded without waiting for them, if they have been read by now: a
 * render of it must then be restarted. Not while one of its renders is at a batch. When they came,
 * *out_warnings is a line, with its end, for each that cannot be read; materials go on without it. The text
 * is the scene's. */
enum rnd_textures { RND_TEXTURES_IN_USE, RND_TEXTURES_READING, RND_TEXTURES_CAME };
enum rnd_textures rnd_scene_take_textures(struct rnd_scene *scene, const char **out_warnings);

const struct rnd_scene_info *rnd_scene_info(const struct rnd_scene *scene);

/* --- where samples fall --- */

/* What a batch is aimed at. */
struct rnd_aim {
    float gaze[3];     /* unit, world */
    float view[4];     /* orientation of the viewport, view to world */
    float fov[2];      /* its horizontal and vertical field of view, rad, each in (0, pi) */
    uint64_t sequence; /* of the gaze sample; tiles remember it */
    uint64_t time_ns;  /* when the gaze sample arrived; tiles remember it */
    /* How many times wider than the eye's own acuity fv and fv-exact should be, for a gaze that is not sure:
     * at eccentricity e they then follow m(e / spread), to 80 degrees as ever. 1 or less, also 0: as it is.
     */
    float spread;
    /* Of the display that shows it: fv and fv-exact are no denser than it can show, m(e) no more than its
     * cycles a degree over the eye's 60. 0: it shows all that the eye can see. */
    float pixels_per_degree;
    /* Set by any thread as soon as there is a newer aim: the batch then ends within the time of a wave, and
     * the paths that nobody has begun are left out. NULL: it is traced whole. */
    const atomic_bool *stale;
};

/* A way to place samples on the sphere of directions. */
struct rnd_distribution {
    const char *name;    /* as an option names it */
    const char *summary; /* half a line */
    const char *source;  /* author, year, equation */
    bool is_foveated;    /* follows the eye's acuity: heeds an aim's spread and pixels_per_degree */
    bool has_viewport;   /* heeds an aim's view and fov */
    bool covers_sphere;  /* its density is nowhere 0, so that every tile converges */
    /* Fill out (count x 3, unit vectors, world) from u (count x 2, in [0,1)). */
    void (*sample)(const struct rnd_aim *aim, size_t count, const float *u, float *out);
    /* Density per steradian at a unit direction; integrates to one over the sphere. */
    float (*density)(const struct rnd_aim *aim, const float direction[3]);
};

/* "od", "vp", "fv" (Koskela's polynomial), "fv-exact". NULL if there is none of that name; index in 0.. for a
 * list. */
const struct rnd_distribution *rnd_distribution_find(const char *name);
const struct rnd_distribution *rnd_distribution_at(size_t index);

/* Relative visual acuity m(e) at e degrees from the gaze (Reddy 2001 after Koskela 2018 eq. 1): 1 up to 5.79.
 */
float rnd_acuity(float eccentricity_deg);
/* Eccentricity in degrees, 0 to 80, for u in [0,1): the inverse of the normalised integral of g(e) = 2 pi e
 * m(e); exact to float (Newton on Koskela 2018 eq. 5), and the published fit (eq. 7). */
float rnd_eccentricity_exact(float u);
float rnd_eccentricity_polynomial(float u);

/* Direction from azimuth (right of -Z) and elevation, rad. */
void rnd_direction(float azimuth, float elevation, float out_direction[3]);

/* --- render --- */

struct rnd_render;

struct rnd_render_options {
    int width, height; /* of the film: width a multiple of 2 * RND_TILE, height half of it */
    int threads;       /* 0: one for each processor */
    uint64_t seed;
    int max_bounces; /* 0: Russian roulette alone ends a path */
    float firefly;   /* luminance, before the first surface, that light by way of a second one is clamped to:
                        less noise, and   darker; 0: none is */
    float error_bar; /* relative standard error at which a tile is converged; 0: the default, 0.05 */
    const struct rnd_distribution *distribution;
};

/* NULL and a line in out_error for a bad size or no memory. The eye is where rnd_scene_info() says. The scene
 * must outlive the render, or its use by it: see below. */
struct rnd_render *rnd_render_create(const struct rnd_scene *scene, const struct rnd_render_options *options,
                                     char out_error[RND_ERROR_SIZE]);
void rnd_render_destroy(struct rnd_render *render); /* accepts NULL */
int rnd_render_threads(const struct rnd_render *render);

/* Empty the film and go on with this scene, which may be the same, seen from eye (m), as a render that was
 * just created would: bit for bit. The former scene is not used any more once this returns. Not while a batch
 * runs. Readers may read meanwhile: every tile is as it was or empty, and says by its generation which. */
void rnd_render_restart(struct rnd_render *render, const struct rnd_scene *scene, const double eye[3]);

struct rnd_batch {
    uint64_t paths, rays, not_finite; /* traced in this batch; paths that counted as black because
                                         their radiance was not finite */
    double seconds;                   /* wall time of the batch */
    double place_seconds;             /* of these, drawing and ordering positions */
    double processor_seconds;         /* that all threads together had of the processors, to trace it */
    /* Time of all threads together: within Embree; surfaces, their textures and what they emit; choosing
     * lights; BSDFs; adding to the film. */
    double rays_seconds, surface_seconds, light_seconds, scatter_seconds, film_seconds;
};

/* Trace one batch of paths placed by the render's distribution around aim, and add it to the film. Blocks
 * until done; the caller's thread works too. now_ns is the time that tiles remember as aimed. One thread at a
 * time. */
void rnd_render_batch(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns, uint32_t paths,
                      struct rnd_batch *out_batch);

/* Trace one path in every cell of 16 x 16 pixels, so that every coarse pixel of the panorama has something.
 */
void rnd_render_outline(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns,
                        struct rnd_batch *out_batch);

/* Trace a batch as rnd_render_batch() does, then make the same calls to Embree once more, by the same threads
 * and with nothing in between: *out_seconds is what traversal alone takes of the processors' time. Negative
 * if memory is short. */
void rnd_render_retrace(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths,
                        struct rnd_batch *out_batch, double *out_seconds);

/* --- film: any thread may read, while a batch runs --- */

struct rnd_tile {
    uint64_t samples;   /* paths in it */
    uint32_t unvisited; /* pixels without any */
    /* Relative standard error of its pixels from the half-buffers, that only one in twenty of its blocks of
     * 8 x 8 pixels exceeds: relative to the block's mean, or to a hundredth of the picture's median if that
     * is more. Where a pixel has found nothing, what may be there unseen counts too. INFINITY before known.
     */
    float error;
    float sure_error; /* the larger of the last two; INFINITY before all pixels had 16 paths at both */
    float luminance;  /* mean, once the error is known */
    bool converged;   /* sure_error is not above the bar */
    uint64_t gaze_sequence, gaze_ns, aimed_ns; /* of the newest batch that reached it */
    uint32_t generation;                       /* of the film, from 1: each restart begins the next */
};

/* Level 0 is the film; every next level halves it, down to the last that is whole tiles. */
int rnd_render_levels(const struct rnd_render *render);

/* State of all level-0 tiles, row by row: (width / RND_TILE) * (height / RND_TILE) of them. */
void rnd_render_tiles(struct rnd_render *render, struct rnd_tile *out_tiles);

/* Update tiles, laid out as by rnd_render_tiles(): write those that changed since the last call, at the first
 * call all. Returns their number; their indices go to out_index, which has room for all. Never waits for a
 * batch. For one thread. */
uint32_t rnd_render_published(struct rnd_render *render, struct rnd_tile *tiles, uint32_t *out_index);

/* Is the tile's sure_error below what the eye can see at the eccentricity of its nearest point? Contrast
 * threshold by Geisler and Perry 1998: white noise of relative standard error s has contrast s f sqrt(1.5 pi)
 * / p in an octave around f cycles per degree at p pixels per degree; it is visible where that times 64
 * exp(-0.106 f (e + 2.3) / 2.3) exceeds 1/2. */
float rnd_visible_error(float eccentricity_deg, float pixels_per_degree);
bool rnd_tile_settled(const struct rnd_render *render, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3]);

/* What is to be shown of the tile (x, y) at a level: RND_TILE x RND_TILE x RGB floats, of radiance. Every
 * pixel of the film counts alike, however many paths it has. A pixel without a path takes the mean of the
 * smallest square around it, by powers of two within the tile, that has one; one that found no light in few
 * paths borrows from such a square, which keeps its mean: see fill.c. False if the tile is empty, or just
 * being emptied; also if a thread that adds to it has been put aside by the system meanwhile: it is worth
 * another try then, a little later. *out_state (may be NULL) sums up the level-0 tiles below it. */
bool rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state);

/* The whole film, width x height: mean radiance (RGB), number of paths, and standard error of the luminance
 * from the half-buffers (0 where fewer than two paths fell). Each may be NULL. Pixels without a path are 0.
 * All of it is of one generation: a restart waits until it is read. */
void rnd_render_resolve(struct rnd_render *render, float *out_rgb, float *out_samples, float *out_error);

/* Write the film as EXR: R, G, B, "samples", "error" (half floats where these hold the values), marked as an
 * equirectangular environment for 360 viewers. fovead-image writes it. It takes 20 bytes a pixel meanwhile.
 * file is a regular one, open for writing and empty; name is what errors call it. False with a line in
 * out_error if not all of it is written. */
bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name, char out_error[RND_ERROR_SIZE]);

/* --- images --- */

/* An image file as width x height x RGB floats, linear. *out_display (may be NULL): whether the file's values
 * are encoded for a display. Integers of any width are, as sRGB, unless the file names another transfer
 * function (gamma) or says that they are linear; floats are linear. malloc'ed: the caller frees. NULL and a
 * line in out_error if it cannot be read or is over 1 Gi pixels. */
float *rnd_image_read(const char *path, int *out_width, int *out_height, bool *out_display,
                      char out_error[RND_ERROR_SIZE]);
/* The one channel of that name, width x height floats. */
float *rnd_image_read_channel(const char *path, const char *channel, int *out_width, int *out_height,
                              char out_error[RND_ERROR_SIZE]);

/* Write RGB floats, linear: .exr as half floats where these hold them, else as floats; .png, .jpg and what
 * else OpenImageIO writes as 8-bit sRGB, clamped. The end of name tells the format. file is a regular one,
 * open for writing and empty. equirectangular: mark it as a 360-degree panorama. False with a line in
 * out_error if the picture cannot be encoded, or not all of it is written. */
bool rnd_image_write(FILE *file, const char *name, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE]);

/* A rectilinear view of an equirectangular image: out is out_width x out_height x RGB; fov_x in rad, (0, pi);
 * orientation view to world. Trilinear over a mipmap of the image, so that poles and wide views do not alias
 * (Koskela 2018 section 4.3). */
bool rnd_image_view(const float *rgb, int width, int height, const float orientation[4], float fov_x,
                    int out_width, int out_height, float *out_rgb);

/* --- text --- */

/* Put blanks for control characters (C0, DEL, C1): names of files and in files may hold anything. */
void rnd_make_printable(char *text);

/* --- metrics --- */

/* Two pictures of the same size, or two sequences of frames, and how they are seen. */
struct rnd_pair {
    const float *reference, *test; /* height x width x RGB, linear; of a sequence, the first frames */
    int width, height;             /* 1 to RND_METRIC_MAX_SIDE */
    bool panorama;                 /* equirectangular, the whole sphere; else flat, as a screen shows it */
    bool display;                  /* values from 0 to 1 that a display shows; else radiance */
    float pixels_per_degree;       /* as the eye sees the middle of the picture; 0: not known */
    const float *gaze;             /* unit direction (a flat picture's middle is -Z); NULL: not known */
    /* How much each pixel counts, height x width, beside its solid angle in a panorama: 0 leaves it out.
     * NULL: all count alike. */
    const float *weight;
    /* Of a sequence: put the next frames into reference and test; false after the last. NULL: a picture. */
    bool (*next)(struct rnd_pair *pair);
    void *frames;        /* for next() */
    float frame_seconds; /* of a sequence: from one frame to the next */
};

enum { RND_METRIC_MAX_SIDE = 65536, RND_METRIC_FIGURES = 12, RND_METRIC_NOTE_SIZE = 256 };

/* What a metric found. */
struct rnd_measure {
    double value;
    int figures; /* more that it found, for scripts */
    struct {
        const char *key; /* "a.b": b of the object a */
        double value;
        bool whole; /* a count */
    } figure[RND_METRIC_FIGURES];
    char note[RND_METRIC_NOTE_SIZE]; /* more lines for people, each with its end; or empty */
};

enum rnd_metric_values { RND_ANY_VALUES, RND_RADIANCE, RND_DISPLAY_VALUES };

/* A measure of how different two pictures are. */
struct rnd_metric {
    const char *name;              /* and key of its value, for scripts */
    const char *label, *unit;      /* for people; no unit: "" */
    const char *summary;           /* what the value is */
    const char *range;             /* what its ends mean; NULL: it has none */
    const char *source;            /* author, year */
    int decimals;                  /* to be shown; 0: six digits */
    bool higher_is_better;         /* else lower */
    bool sphere;                   /* of a panorama, by solid angle; else any picture is taken as flat */
    bool sequence;                 /* of frames; else of one pair of pictures */
    enum rnd_metric_values values; /* that it is made for */
    bool needs_density;            /* pixels_per_degree */
    bool needs_gaze;
    bool map; /* it has a value for each pixel */
    /* See rnd_measure(), which has checked the pair. */
    bool (*compute)(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE]);
};

/* The metrics "hdr_flip", "ldr_flip", "relative_mse", "relative_rmse" and "psnr_db". NULL if there is none of
 * that name; index in 0.. for a list. */
const struct rnd_metric *rnd_metric_find(const char *name);
const struct rnd_metric *rnd_metric_at(size_t index);

/* Is the metric made for such a pair, and is all known that it needs? */
bool rnd_metric_fits(const struct rnd_metric *metric, const struct rnd_pair *pair);

/* Compute a metric. out_map (may be NULL) takes the value of each pixel, height x width, if the metric has a
 * map. False and a line in out_error if the metric does not fit, for a size out of range, a pixel that is not
 * finite, weights below 0 or all 0, what the metric itself refuses, or no memory. */
bool rnd_measure(const struct rnd_metric *metric, const struct rnd_pair *pair, float *out_map,
                 struct rnd_measure *out_measure, char out_error[RND_ERROR_SIZE]);

/* Weights of a panorama, height x width: 1 from inner to outer rad around gaze, else 0. */
void rnd_weigh_ring(int width, int height, const float gaze[3], float inner, float outer, float *out_weight);

/* Pixels per degree: of the screen of FLIP's authors, 3840 pixels on 0.7 m seen from 0.7 m; and the most that
 * FLIP takes, from 1. */
#define RND_FLIP_PPD 67.020643f
enum { RND_FLIP_MAX_PPD = 300 };

#endif
