/* The gaze decides how soon a pixel converges, but not what it converges to: a room that is rendered around a
 * wandering gaze has the same mean in every tile as one that is rendered evenly. */
#include "renderer_files.h"

enum {
    WIDTH = 384,
    HEIGHT = 192,
    PIXELS = WIDTH * HEIGHT,
    ACROSS = WIDTH / RND_TILE,
    TILES = ACROSS * (HEIGHT / RND_TILE),
    RENDERS = 5, /* of each kind; their spread gives the standard error */
    BATCHES = 60,
    PATHS = SANITIZED ? 3000 : 6000,
};

/* Render once. value is the mean of a pixel's channels. A pixel without a path is removed from the mask: only
 * the gaze decides which pixels these are, so leaving them out causes no bias. */
static void render_once(const struct rnd_scene *scene, const char *distribution, uint64_t seed,
                        float value[PIXELS], bool mask[PIXELS])
{
    static float rgb[3 * PIXELS], samples[PIXELS];
    const struct rnd_render_options options = {
        .width = WIDTH, .height = HEIGHT, .seed = seed, .distribution = rnd_distribution_find(distribution)};
    char error[RND_ERROR_SIZE];
    struct rnd_batch batch;
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    for (int i = 0; i < BATCHES; i++) {
        const double azimuth = i * 6.0 * M_PI / BATCHES,
                     elevation = 0.6 * sin(i * 1.7); /* three times around */
        const struct rnd_aim aim =
            files_aim(cos(elevation) * sin(azimuth), sin(elevation), -cos(elevation) * cos(azimuth));
        rnd_render_batch(render, &aim, 0, PATHS, &batch);
        assert_int_equal(batch.not_finite, 0);
    }
    rnd_render_resolve(render, rgb, samples, NULL);
    rnd_render_destroy(render);
    for (int i = 0; i < PIXELS; i++) {
        value[i] = (rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2]) / 3.0f;
        mask[i] = mask[i] && samples[i] > 0.0f;
    }
}

/* The mean of a tile's pixels within the mask over all renders, and the variance of that mean from the spread
 * of the renders. */
static void moments(float (*value)[PIXELS], const bool *mask, int tile, double *out_mean,
                    double *out_variance)
{
    double mean[RENDERS] = {0}, pixels = 0.0;
    *out_mean = *out_variance = 0.0;
    for (int k = 0; k < RND_TILE * RND_TILE; k++) {
        const int i =
            (tile / ACROSS * RND_TILE + k / RND_TILE) * WIDTH + tile % ACROSS * RND_TILE + k % RND_TILE;
        if (!mask[i]) continue;
        pixels += 1.0;
        for (int r = 0; r < RENDERS; r++) mean[r] += value[r][i];
    }
    for (int r = 0; r < RENDERS; r++) *out_mean += (mean[r] /= pixels) / RENDERS;
    for (int r = 0; r < RENDERS; r++)
        *out_variance += (mean[r] - *out_mean) * (mean[r] - *out_mean) / (RENDERS - 1) / RENDERS;
}

static double share_seen(const bool *mask, int tile)
{
    double seen = 0.0;
    for (int k = 0; k < RND_TILE * RND_TILE; k++)
        seen +=
            mask[(tile / ACROSS * RND_TILE + k / RND_TILE) * WIDTH + tile % ACROSS * RND_TILE + k % RND_TILE];
    return seen / (RND_TILE * RND_TILE);
}

static void gaze_is_no_bias(void **state)
{
    (void)state;
    static float even[RENDERS][PIXELS], gazed[RENDERS][PIXELS];
    static bool mask[PIXELS];
    struct rnd_scene *scene = files_load(files_room("room.obj"), NULL, NULL, NULL);
    memset(mask, true, sizeof mask);
    for (int r = 0; r < RENDERS; r++) {
        render_once(scene, "od", 1000 + (uint64_t)r, even[r], mask);
        render_once(scene, "fv", 2000 + (uint64_t)r, gazed[r], mask);
    }
    rnd_scene_destroy(scene);

    int compared = 0;
    double squares = 0.0;
    for (int t = 0; t < TILES; t++) {
        double a, b, va, vb;
        if (share_seen(mask, t) < 0.25) continue;
        moments(even, mask, t, &a, &va);
        moments(gazed, mask, t, &b, &vb);
        const double deviation = (b - a) / sqrt(va + vb);
        print_message(
            "tile %2d, %2.0f %% of it: OD %.4f, FV %.4f: %+.2f %%, %+.2f standard errors of %.2f %%\n", t,
            100.0 * share_seen(mask, t), a, b, 100.0 * (b / a - 1.0), deviation, 100.0 * sqrt(va + vb) / a);
        /* Student's t with about eight degrees of freedom exceeds this with a probability of 2e-4 per tile.
         */
        assert_true(fabs(deviation) < 6.5);
        assert_true(sqrt(va + vb) / a < (SANITIZED ? 0.08 : 0.05)); /* otherwise it would prove nothing */
        squares += deviation * deviation;
        compared++;
    }
    print_message("%d tiles, mean square %.2f\n", compared, squares / compared);
    assert_true(compared >= ACROSS);
    assert_true(squares / compared < 4.0); /* 1.3 is expected for t with eight degrees of freedom */
}

/* Sum of the room's radiance with indirect light clamped, after this many bounces (0: no limit). */
static double render_clamped(const struct rnd_scene *scene, float clamp, int bounces)
{
    static float rgb[3 * PIXELS];
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .seed = 5,
                                               .max_bounces = bounces,
                                               .firefly = clamp,
                                               .distribution = rnd_distribution_find("od")};
    char error[RND_ERROR_SIZE];
    struct rnd_batch batch;
    double sum = 0.0;
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    for (int i = 0; i < (SANITIZED ? 2 : 8); i++) rnd_render_batch(render, &aim, 0, PIXELS / 2, &batch);
    rnd_render_resolve(render, rgb, NULL, NULL);
    rnd_render_destroy(render);
    for (int i = 0; i < 3 * PIXELS; i++) sum += (double)rgb[i];
    return sum;
}

/* Where samples fall does not depend on what earlier samples found. Films of three worlds have the same
 * number of paths in every pixel: a room, an even world that converges at once, and a world that stays black
 * except for light that hardly any path finds. Otherwise a place whose rare light has not been found yet
 * would get fewer samples and become too dark. */
static void light_moves_no_sample(void **state)
{
    (void)state;
    enum { W = 128, H = 64, BATCHES_EACH = 60 };
    static float samples[3][W * H];
    static const char *const modes[] = {"od", "vp", "fv", "fv-exact"};
    files_text("speck.mtl", "newmtl dark\nKd 0 0 0\nnewmtl emitter\nKd 0 0 0\nKe 1e6 1e6 1e6\n");
    const char *speck = files_text("speck.obj", "mtllib speck.mtl\nusemtl dark\nv 0 -9 0\nv 1e-3 -9 0\n"
                                                "v 0 -9 1e-3\nf 1 2 3\n");
    struct rnd_scene *scene[3] = {files_load(files_room("room.obj"), NULL, NULL, NULL)};
    scene[1] = files_load(speck, files_env("even.exr", 0.5f), NULL, (float[]){0, 0, 0});
    const char *star = files_text("star.obj", "mtllib speck.mtl\nusemtl emitter\nv 0 -9 0\nv 1e-3 -9 0\n"
                                              "v 0 -9 1e-3\nf 1 2 3\n");
    scene[2] = files_load(star, NULL, NULL, (float[]){0, 0, 0});
    for (size_t m = 0; m < sizeof modes / sizeof *modes; m += SANITIZED ? 2 : 1) {
        for (int k = 0; k < 3; k++) {
            const struct rnd_render_options options = {
                .width = W, .height = H, .seed = 3, .distribution = rnd_distribution_find(modes[m])};
            char error[RND_ERROR_SIZE];
            struct rnd_batch batch;
            struct rnd_render *render = rnd_render_create(scene[k], &options, error);
            if (!render) fail_msg("%s", error);
            const struct rnd_aim aim = files_aim(0.3, 0.2, -1);
            for (int i = 0; i < BATCHES_EACH; i++) rnd_render_batch(render, &aim, 0, W * H, &batch);
            rnd_render_resolve(render, NULL, samples[k], NULL);
            struct rnd_tile tiles[2];
            rnd_render_tiles(render, tiles);
            if (k == 1 && m == 0) assert_true(tiles[0].converged && tiles[1].converged);
            rnd_render_destroy(render);
        }
        int apart = 0;
        for (int i = 0; i < W * H; i++)
            apart += samples[0][i] != samples[1][i] || samples[0][i] != samples[2][i];
        print_message("%s: %d of %d pixels have another number of paths in another light\n", modes[m], apart,
                      W * H);
        assert_int_equal(apart, 0);
    }
    for (int k = 0; k < 3; k++) rnd_scene_destroy(scene[k]);
}

/* The clamp is off unless an option asks for it, and the test prints what it costs: the room's mean radiance
 * with clamped indirect light as a share of that without. Only light that came by way of a second surface is
 * reduced. Direct light is not, whether it was drawn as a light or hit by a direction of the surface. */
static void clamp_darkens(void **state)
{
    (void)state;
    static const float clamp[] = {0, 1000, 1, 0.1f};
    double all[4], direct[4];
    struct rnd_scene *scene = files_load(files_room("room.obj"), NULL, NULL, NULL);
    for (int k = 0; k < 4; k++) {
        all[k] = render_clamped(scene, clamp[k], 0);
        direct[k] = render_clamped(scene, clamp[k], 1);
        print_message("clamped to %g: mean %.2f %% of what it is, direct light %.2f %%\n", (double)clamp[k],
                      100 * all[k] / all[0], 100 * direct[k] / direct[0]);
    }
    rnd_scene_destroy(scene);
    assert_true(all[1] == all[0]); /* no path in this room is that bright */
    assert_true(all[2] < all[1] && all[3] < 0.98 * all[0]);
    for (int k = 1; k < 4; k++) assert_true(direct[k] == direct[0]);
}

/* Render a small plate below the camera, on the floor of a room that is lit indirectly by its ceiling.
 * Returns the number of its pixels. */
static int render_plate(const char *name, float albedo, float *out_value)
{
    static float rgb[3 * PIXELS];
    char text[4000], error[RND_ERROR_SIZE];
    const struct rnd_render_options options = {
        .width = WIDTH, .height = HEIGHT, .seed = 7, .distribution = rnd_distribution_find("od")};
    struct rnd_batch batch;
    int count = 0;
    snprintf(text, sizeof text,
             "newmtl wall\nKd .5 .5 .5\nnewmtl emitter\nKd 0 0 0\nKe 9 9 9\nnewmtl plate\nKd %g %g %g\n",
             albedo, albedo, albedo);
    files_text("plate.mtl", text);
    strcpy(text, "mtllib plate.mtl\nusemtl emitter\nv -.3 .5 -.3\nv .3 .5 -.3\nv 0 .5 .3\nf 1 2 3\n");
    files_box(text, sizeof text, "wall", (double[]){-1, -1, -1}, (double[]){1, 1, 1});
    files_box(text, sizeof text, "wall", (double[]){-.5, .4, -.5}, (double[]){.5, .45, .5});
    files_box(text, sizeof text, "plate", (double[]){-.1, -1, -.1}, (double[]){.1, -.99, .1});
    struct rnd_scene *scene = files_load(files_text(name, text), NULL, NULL, (float[]){0, -.8f, 0});
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    const struct rnd_aim aim = files_aim(0, -1, 0);
    for (int i = 0; i < (SANITIZED ? 2 : 8); i++) rnd_render_batch(render, &aim, 0, PIXELS, &batch);
    rnd_render_resolve(render, rgb, NULL, NULL);
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
    /* pixels within 24 degrees of straight down */
    for (int i = HEIGHT * 156 / 180 * WIDTH; i < PIXELS; i++) out_value[count++] = rgb[3 * i];
    return count;
}

/* A surface that is ten times darker has the same relative noise: its picture is the brighter one's, scaled,
 * except for the little light that returns to it. */
static void dark_is_as_sure(void **state)
{
    (void)state;
    static float bright[PIXELS], dark[PIXELS];
    const int count = render_plate("bright.obj", 0.2f, bright);
    double mean = 0, apart = 0;
    assert_int_equal(render_plate("dark.obj", 0.02f, dark), count);
    for (int i = 0; i < count; i++) mean += bright[i], apart += fabsf(bright[i] - 10.0f * dark[i]);
    print_message("%d pixels, mean %.4g; they and ten times the darker ones are %.3g %% apart\n", count,
                  mean / count, 100 * apart / mean);
    assert_true(mean > 0 && apart < 0.02 * mean);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(gaze_is_no_bias),
                                       cmocka_unit_test(light_moves_no_sample),
                                       cmocka_unit_test(clamp_darkens), cmocka_unit_test(dark_is_as_sure)};
    return cmocka_run_group_tests_name("renderer_unbiased", tests, files_setup, files_teardown);
}
