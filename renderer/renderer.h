/* renderer: a progressive path tracer of 360-degree pictures whose samples fall where the eye can use them.
 *
 * A scene is loaded once; a render adds batches of paths to an equirectangular film, each batch placed by a
 * distribution around the newest gaze; tiles of the film can be read at any time at any level of detail. This
 * folder knows nothing of gaze devices or sockets.
 *
 * Conventions
 * - Frames follow OpenXR and glTF: right-handed, +X right, +Y up, -Z forward; metres, radians; quaternions
 *   (x, y, z, w).
 * - Equirectangular: u = 1/2 + atan2(x, -z) / 2 pi, v = 1/2 - asin(y) / pi, u wraps, row 0 is up.
 * - Radiance is linear, scene-referred, Rec.709 primaries, float.
 * - Every random number is addressed by (seed, pixel, sample, dimension): the same batches give the same film
 *   bit for bit, whatever the number of threads.
 * - What is rendered changes only by rnd_render_restart(), which empties the film: a new generation of it.
 * - Errors are one line of text in a caller's buffer of RND_ERROR_SIZE bytes that names the file and the
 *   cause.
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
    RND_TILE = 64,          /* pixels a side of a tile, at every level */
    RND_MAX_WIDTH = 32768,  /* of a film; the height is half of it */
    RND_MOST_CHANNELS = 20, /* of a film */
};

/* --- scene --- */

struct rnd_scene;

/* Two programs that lie beside this one read files: fovead-reader reads scenes, fovead-image reads and writes
 * pictures. A file that crashes one of them, or exceeds its limits, is refused and does no other harm.
 * fovead-image takes a while to start, and serves many scenes and renders. NULL if memory is short. */
struct rnd_image_program *rnd_image_program_create(void);
/* Start the program, if it does not run, without waiting until it is ready. Without this call it starts with
 * the first picture. False and a line in out_error if the program is missing. */
bool rnd_image_program_start(struct rnd_image_program *program, char out_error[RND_ERROR_SIZE]);
/* Accepts NULL. The program ends with the last scene or render that uses it. */
void rnd_image_program_destroy(struct rnd_image_program *program);

struct rnd_scene_options {
    const char *path;     /* glTF, GLB, OBJ, or what else assimp reads */
    const char *env_path; /* equirectangular environment map, or NULL */
    bool has_sun;
    float sun[4]; /* azimuth (deg, right of -Z), elevation (deg), irradiance on a surface facing it, angular
                     diameter (deg, 0 to 90) */
    float env_azimuth; /* deg by which the environment map is turned to the right */
    /* Load without waiting for textures, except those that decide where a surface is or what it emits. The
     * first picture is rendered without the others. See rnd_scene_take_textures(). */
    bool textures_later;
    /* Shadow rays pass straight through glass that refracts or has a roughness of up to 0.25, and take with
     * them what the glass transmits. Far less noise, but no caustics, and sharp shadows behind rough glass.
     * Off: unbiased. */
    bool clear_glass;
    /* Limits of the programs that read files: MiB of memory, and seconds of processor time for one file; 0:
     * the defaults of reader_limits.c. Embree's trees may take as much memory again. */
    uint32_t reader_mib, reader_seconds;
    /* NULL: the scene starts its own. */
    struct rnd_image_program *image_program;
    const atomic_bool *cancel; /* set by any thread as soon as the scene is not wanted any more; or NULL */
    bool has_camera;
    double camera[3]; /* the camera's position, m; without it the file's first camera, else the middle of the
                      scene's bounds */
};

struct rnd_scene_info {
    uint64_t triangles, emissive_triangles; /* a mesh that has many instances counts once for each */
    uint32_t meshes, materials, textures, punctual_lights;
    bool has_env, has_sun;
    double camera[3];                   /* the camera's position, m */
    double bounds[2][3];                /* lowest and highest corner, m */
    uint64_t texture_bytes;             /* 0 while they are read */
    double read_seconds, build_seconds; /* import and textures; BVH and light tables */
    const char *unsupported; /* features that the file uses and the renderer lacks, comma-separated, or "" */
    /* All other files that the scene's file names, whether they were found or not: files_bytes bytes of
     * paths, each with its NUL. The names may hold control characters. */
    const char *files;
    size_t files_bytes;
    const char *warnings; /* lines about what was mended and images that cannot be read, or "" */
};

/* Load a scene. NULL and a line in out_error when the file is missing or broken, holds no triangle or a
 * vertex that is not finite, the environment map cannot be read, or nothing in it gives light. The caller
 * frees with rnd_scene_destroy(). */
struct rnd_scene *rnd_scene_load(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE]);
void rnd_scene_destroy(struct rnd_scene *scene); /* accepts NULL; after every render of it */

/* Of a scene that was loaded with textures_later: start to use its textures, if they have all been read. Call
 * it between batches. After RND_TEXTURES_CAME every render of the scene must be restarted, and *out_warnings
 * has a line for each image that cannot be read, whose materials do without it. The scene owns that text. */
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
    /* For a gaze that is uncertain: foveated distributions follow m(e / spread) at eccentricity e, up to 80
     * degrees. 1 or less: they follow m(e). */
    float spread;
    /* Of the display: foveated distributions are no denser than it can show; m(e) is limited to its cycles
     * per degree over the eye's 60. 0: no limit. */
    float pixels_per_degree;
    /* Any thread sets this when there is a newer aim. The batch then leaves out the paths that no thread has
     * begun, and ends within the time of a wave. NULL: the batch is always traced whole. */
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

/* By name, or by index from 0. NULL if there is none. */
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

/* Planes: what a film can keep of the first surface that each path hits, as means over the paths of a pixel.
 * The name of one and half a line on it, by index from 0; NULL if there is none. */
const char *rnd_plane_at(size_t index, const char **out_summary);

struct rnd_render;
struct rnd_reconstruction; /* a way to show the samples so far: reconstruct/reconstruction.h */

struct rnd_render_options {
    int width, height; /* of the film: width a multiple of 2 * RND_TILE, height half of it */
    int threads;       /* 0: one for each processor */
    uint64_t seed;
    int max_bounces; /* 0: Russian roulette alone ends a path */
    float firefly;   /* indirect light is clamped to this luminance where it arrives at a surface: less noise,
                        but darker; 0: not clamped */
    float error_bar; /* relative standard error at which a tile is converged; 0: the default, 0.05 */
    const struct rnd_distribution *distribution;
    const struct rnd_reconstruction *reconstruction; /* what rnd_render_read() shows; NULL: the default */
    uint32_t planes; /* that the film keeps: bit i for rnd_plane_at(i); 0: none, at no cost */
};

/* The camera is where rnd_scene_info() says. The scene must outlive the render, or be replaced by
 * rnd_render_restart() before it is destroyed. NULL and a line in out_error for a bad size or no memory. */
struct rnd_render *rnd_render_create(const struct rnd_scene *scene, const struct rnd_render_options *options,
                                     char out_error[RND_ERROR_SIZE]);
void rnd_render_destroy(struct rnd_render *render); /* accepts NULL */
int rnd_render_threads(const struct rnd_render *render);

/* Empty the film, and go on with this scene, which may be the same, and the camera at that position (m). What
 * follows is bit for bit what a new render would give. Call it between batches; the former scene is not used
 * after it. Other threads may read the film meanwhile: each tile is whole or empty, and its generation tells
 * which. */
void rnd_render_restart(struct rnd_render *render, const struct rnd_scene *scene, const double position[3]);

struct rnd_batch {
    uint64_t paths, rays;     /* traced in this batch */
    uint64_t not_finite;      /* paths whose radiance was not finite: they count as black */
    double seconds;           /* wall time of the batch */
    double place_seconds;     /* of these, drawing and sorting positions */
    double processor_seconds; /* processor time of all threads, for tracing */
    /* Wall time summed over all threads: in Embree; surfaces, textures and emission; choosing lights; BSDFs;
     * adding to the film. */
    double rays_seconds, surface_seconds, light_seconds, scatter_seconds, film_seconds;
};

/* Trace a batch of paths, placed around aim by the render's distribution, and add it to the film. The calling
 * thread works too, until the batch is done. Tiles keep now_ns as aimed_ns. For one thread at a time. */
void rnd_render_batch(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns, uint32_t paths,
                      struct rnd_batch *out_batch);

/* Trace one path in every cell of 16 x 16 pixels, so that every coarse pixel of the panorama has something.
 */
void rnd_render_outline(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns,
                        struct rnd_batch *out_batch);

/* Trace a batch as rnd_render_batch() does. Then the same threads repeat all its calls to Embree, and nothing
 * else: *out_seconds is the processor time of traversal alone, or negative if memory is short. */
void rnd_render_retrace(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths,
                        struct rnd_batch *out_batch, double *out_seconds);

/* --- film: any thread may read, while a batch runs --- */

struct rnd_tile {
    uint64_t samples;   /* paths in it */
    uint32_t unvisited; /* pixels without any */
    /* Relative standard error of the tile's pixels, by their half-buffers: only one in twenty of its blocks
     * of 8 x 8 pixels exceeds it. It is relative to the block's mean, or to a hundredth of the picture's
     * median if that is more. Light that may have been missed counts as error. INFINITY until it is known. */
    float error;
    float sure_error; /* larger one of the last two errors; INFINITY until all pixels had 16 paths at both */
    float luminance;  /* mean, once the error is known */
    bool converged;   /* sure_error is not above the bar */
    uint64_t gaze_sequence, gaze_ns, aimed_ns; /* of the newest batch that reached it */
    uint32_t generation;                       /* of the film, from 1: each restart begins the next */
};

/* Level 0 is the film; every next level halves it, down to the last that is whole tiles. */
int rnd_render_levels(const struct rnd_render *render);

/* State of all level-0 tiles, row by row: (width / RND_TILE) * (height / RND_TILE) of them. */
void rnd_render_tiles(struct rnd_render *render, struct rnd_tile *out_tiles);

/* Write the state of each tile that has changed since the last call, into tiles as rnd_render_tiles() lays
 * them out. The first call writes all. Returns how many; their indices go to out_index, which has room for
 * all. Never waits for a batch. For one thread. */
uint32_t rnd_render_published(struct rnd_render *render, struct rnd_tile *tiles, uint32_t *out_index);

/* Is the tile's sure_error below what the eye can see at the eccentricity of its nearest point? Contrast
 * threshold by Geisler and Perry 1998: white noise of relative standard error s has contrast s f sqrt(1.5 pi)
 * / p in an octave around f cycles per degree at p pixels per degree; it is visible where that times 64
 * exp(-0.106 f (e + 2.3) / 2.3) exceeds 1/2. */
float rnd_visible_error(float eccentricity_deg, float pixels_per_degree);
/* The same of a change that comes at once: the relative standard deviation of the change of a tile's pixels
 * that is half of the threshold for flicker of 5 Hz at 30 cd/m2. Contrast sensitivity as in FovVideoVDP
 * (Mantiuk et al. 2021). */
float rnd_visible_flicker(float eccentricity_deg, float pixels_per_degree);
bool rnd_tile_settled(const struct rnd_render *render, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3]);

/* What a client is shown of the tile (x, y) at a level: RND_TILE x RND_TILE x RGB floats, radiance, as the
 * render's reconstruction has it. The default fills pixels without a path from others of the tile. All pixels
 * of the film count alike, whatever the number of their paths. False if there is nothing to show yet, or if
 * the tile is being emptied, or is locked by a thread that the system has suspended: then try again later.
 * *out_state (may be NULL) sums up the level-0 tiles that it covers. */
bool rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state);

/* The whole film, width x height: mean radiance (RGB), number of paths, and standard error of the luminance
 * from the half-buffers (0 where fewer than two paths fell). Each may be NULL. Pixels without a path are 0.
 * All of it is of one generation: a restart waits until it is read. */
void rnd_render_resolve(struct rnd_render *render, float *out_rgb, float *out_samples, float *out_error);

/* Channels: what files and viewers are given of each pixel. The name of one of a render's, by index from 0:
 * "R", "G", "B" (mean radiance), "samples" (number of paths), "error" (standard error of the luminance from
 * the half-buffers), and those of its planes, as "albedo.R", at most RND_MOST_CHANNELS together. NULL after
 * the last. They stay the same as long as the render is there. */
const char *rnd_render_channel(const struct rnd_render *render, int index);

/* All channels of the level-0 tile (x, y): RND_TILE x RND_TILE pixels, row by row, the channels of a pixel
 * side by side. rnd_render_save() writes the same values. A path that hits nothing counts as 0 in a plane; a
 * pixel without a path is 0 in all channels; instances are those of the newest path. False if a thread that
 * the system has suspended holds the tile: then try again later. *out_state (may be NULL) is of the same
 * moment. */
bool rnd_render_read_channels(struct rnd_render *render, int x, int y, float *out_values,
                              struct rnd_tile *out_state);

/* How bright pictures for displays are. */
struct rnd_exposure {
    bool automatic; /* half of the sphere above middle grey, half below */
    double stops;   /* else by so many brighter than radiance 1 = white */
};
/* Expose a panorama, in place. */
void rnd_expose(const struct rnd_exposure *exposure, float *rgb, int width, int height);

/* Write the film, marked as a panorama for 360-degree viewers, in the format that the end of name says: .exr
 * has all channels, as half floats where these hold the values; .png and .jpg have what rnd_render_read()
 * shows, exposed, as 8-bit sRGB. fovead-image writes it; meanwhile it takes 4 bytes here per channel and
 * pixel. file is a regular file, open for writing and empty; errors call it name. False with a line in
 * out_error if not all of it is written. */
bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name,
                     const struct rnd_exposure *exposure, char out_error[RND_ERROR_SIZE]);

/* --- images --- */

/* Read an image file as width x height x RGB floats, linear. *out_display (may be NULL): whether the file's
 * values are encoded for a display. Integers of any width are, as sRGB, unless the file names another
 * transfer function (gamma) or says that they are linear; floats are linear. The caller frees. NULL and a
 * line in out_error if the file cannot be read or has more than 1 Gi pixels. */
float *rnd_image_read(const char *path, int *out_width, int *out_height, bool *out_display,
                      char out_error[RND_ERROR_SIZE]);
/* The one channel of that name, width x height floats. */
float *rnd_image_read_channel(const char *path, const char *channel, int *out_width, int *out_height,
                              char out_error[RND_ERROR_SIZE]);

/* Write RGB floats, linear, in the format that the end of name says: .exr as half floats if these hold the
 * values, else as floats; .png, .jpg and other formats of OpenImageIO as 8-bit sRGB, clamped. file is a
 * regular file, open for writing and empty. equirectangular: mark it as a 360-degree panorama. False with a
 * line in out_error if the picture cannot be encoded, or not all of it is written. */
bool rnd_image_write(FILE *file, const char *name, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE]);

/* A rectilinear view. */
struct rnd_view {
    float orientation[4]; /* view to world */
    float fov_x;          /* horizontal field of view, rad, in (0, pi) */
    int width, height;    /* pixels */
};

/* Fill out_rgb, of the view's size x RGB, from an equirectangular image. Trilinear over a mipmap of the
 * image, so that poles and wide views do not alias (Koskela 2018 section 4.3). False if memory is short. */
bool rnd_image_view(const float *rgb, int width, int height, const struct rnd_view *view, float *out_rgb);

/* --- text --- */

/* Replace control characters (C0, DEL, C1) by blanks. Names of files, and names in files, may hold them. */
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
