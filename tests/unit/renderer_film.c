/* The film: reading it at every level, judging it, and saving it. */
#include "renderer_room.h"

/* --- reading --- */

/* Mean of a square of side x side values whose corner is (x, y): the mean of those of its four quarters that
 * have a path. Returns false if none has. */
static bool square_mean(const double (*pixel)[4], int width, int x, int y, int side, double out[3])
{
    if (side == 1) {
        memcpy(out, pixel[y * width + x], 3 * sizeof *out);
        return pixel[y * width + x][3] > 0.0;
    }
    double sum[3] = {0}, parts = 0.0;
    for (int i = 0; i < 4; i++) {
        double part[3];
        if (!square_mean(pixel, width, x + i % 2 * side / 2, y + i / 2 * side / 2, side / 2, part)) continue;
        for (int c = 0; c < 3; c++) sum[c] += part[c];
        parts += 1.0;
    }
    for (int c = 0; c < 3; c++) out[c] = parts > 0.0 ? sum[c] / parts : 0.0;
    return parts > 0.0;
}

static void assert_state(const struct rnd_tile *whole, const struct rnd_tile *parts, int span, int x, int y)
{
    struct rnd_tile sum = {.converged = true};
    for (int i = 0; i < span * span; i++) {
        const struct rnd_tile *part =
            &parts[(y * span + i / span) * (WIDTH / RND_TILE) + x * span + i % span];
        sum.samples += part->samples;
        sum.unvisited += part->unvisited;
        sum.error = fmaxf(sum.error, part->error);
        sum.sure_error = fmaxf(sum.sure_error, part->sure_error);
        sum.converged &= part->converged;
        sum.luminance += part->luminance / (float)(span * span);
        if (part->samples == 0 || part->aimed_ns < sum.aimed_ns) continue;
        sum.aimed_ns = part->aimed_ns;
        sum.gaze_ns = part->gaze_ns;
        sum.gaze_sequence = part->gaze_sequence;
    }
    assert_int_equal(whole->samples, sum.samples);
    assert_int_equal(whole->unvisited, sum.unvisited);
    assert_true(whole->error == sum.error && whole->sure_error == sum.sure_error);
    assert_int_equal(whole->converged, sum.converged);
    assert_true(fabsf(whole->luminance - sum.luminance) <= 1e-5f * sum.luminance);
    assert_int_equal(whole->aimed_ns, sum.aimed_ns);
    assert_int_equal(whole->gaze_ns, sum.gaze_ns);
    assert_int_equal(whole->gaze_sequence, sum.gaze_sequence);
}

/* Check at every level that a tile shows the mean of the film's pixels that it covers. */
static void assert_levels(struct rnd_render *render)
{
    static struct film film;
    static double pixel[PIXELS][4]; /* mean, and over how many pixels of the film */
    static float rgb[RND_TILE * RND_TILE * 3];
    struct rnd_tile tiles[TILES], state;
    rnd_render_resolve(render, film.rgb, film.samples, NULL);
    rnd_render_tiles(render, tiles);
    assert_int_equal(rnd_render_levels(render), 3);
    for (int level = 0; level < 3; level++) {
        const int span = 1 << level, width = WIDTH / span, height = HEIGHT / span;
        memset(pixel, 0, sizeof pixel);
        for (int i = 0; i < PIXELS; i++) {
            double *to = pixel[i / WIDTH / span * width + i % WIDTH / span];
            if (film.samples[i] == 0) continue;
            to[3] += 1.0;
            for (int c = 0; c < 3; c++) to[c] += ((double)film.rgb[3 * i + c] - to[c]) / to[3];
        }
        for (int t = 0; t < width / RND_TILE * (height / RND_TILE); t++) {
            const int x = t % (width / RND_TILE), y = t / (width / RND_TILE);
            const bool any = rnd_render_read(render, level, x, y, rgb, &state);
            double mean[3], shown[3] = {0};
            assert_state(&state, tiles, span, x, y);
            assert_int_equal(any, state.samples > 0);
            if (!any) continue;
            for (int i = 0; i < RND_TILE * RND_TILE * 3; i++) {
                assert_true(rgb[i] >= 0.0f && isfinite(rgb[i]));
                shown[i % 3] += rgb[i] / (RND_TILE * RND_TILE);
            }
            assert_true(square_mean(pixel, width, x * RND_TILE, y * RND_TILE, RND_TILE, mean));
            for (int c = 0; c < 3; c++) assert_float_equal(shown[c], mean[c], 1e-4 * mean[c] + 1e-6);
        }
    }
}

static void levels(void **state)
{
    (void)state;
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    assert_levels(render); /* empty */
    const struct rnd_aim aim = files_aim(1, 0.3, -1);
    struct rnd_batch batch;
    rnd_render_batch(render, &aim, 0, 500, &batch); /* most tiles are empty, and clocks are at their start */
    assert_levels(render);
    look_around(render, 6, 5000);
    assert_levels(render);
    rnd_render_destroy(render);
}

/* A tile that no path has reached is reported as empty. */
static void empty_tiles(void **state)
{
    (void)state;
    struct rnd_tile tiles[TILES];
    struct rnd_render *render = make(room, WIDTH, "vp", 1);
    struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    aim.fov[0] = aim.fov[1] = 0.2f;
    rnd_render_batch(render, &aim, 5, 1000, &batch);
    rnd_render_tiles(render, tiles);
    uint64_t paths = 0;
    for (int i = 0; i < TILES; i++) {
        paths += tiles[i].samples;
        assert_true(isinf(tiles[i].error) && isinf(tiles[i].sure_error));
        assert_false(tiles[i].converged);
        if (tiles[i].samples == 0) assert_int_equal(tiles[i].unvisited, RND_TILE * RND_TILE);
        assert_false(
            rnd_tile_settled(render, &tiles[i], i % (WIDTH / RND_TILE), i / (WIDTH / RND_TILE), aim.gaze));
    }
    assert_int_equal(paths, 1000);
    assert_int_equal(tiles[0].samples, 0);
    rnd_render_destroy(render);
}

/* Levels end where halving the size would cut a tile. Wrong sizes are refused with one line. */
static void sizes(void **state)
{
    (void)state;
    static const int levels_of[][2] = {{128, 1}, {256, 2}, {384, 1}, {512, 3}, {768, 2}, {896, 1}, {1024, 4}};
    for (size_t i = 0; i < sizeof levels_of / sizeof *levels_of; i++) {
        struct rnd_render *render = make(room, levels_of[i][0], "od", 1);
        assert_int_equal(rnd_render_levels(render), levels_of[i][1]);
        rnd_render_destroy(render);
    }
    static const int wrong[][2] = {{0, 0},    {64, 32},    {100, 50},      {128, 128},
                                   {192, 96}, {-128, -64}, {65536, 32768}, {2147483647, 1073741823}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        const struct rnd_render_options options = {
            .width = wrong[i][0], .height = wrong[i][1], .distribution = rnd_distribution_at(0)};
        char error[RND_ERROR_SIZE] = "";
        assert_null(rnd_render_create(room, &options, error));
        assert_non_null(strstr(error, "expected a width"));
        assert_null(strchr(error, '\n'));
    }
}

/* A film so large that a tile of its last level has less than one pixel for each of the film's tiles. It is
 * white above the horizon and grey below. */
static void coarsest_level(void **state)
{
    (void)state;
    enum { W = 64, H = 32 };
    float sky[W * H * 3];
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < W * H * 3; i++) sky[i] = i < W * H / 2 * 3 ? 1.0f : 0.125f;
    assert_true(files_image(files_path("sky.exr"), W, H, sky, true, error));
    files_text("speck.mtl", "newmtl m\nKd 0 0 0\n");
    const char *path =
        files_text("speck.obj", "mtllib speck.mtl\nusemtl m\nv 0 -9 0\nv 0.1 -9 0\nv 0 -9 0.1\nf 1 2 3\n");
    struct rnd_scene *scene = files_load(path, files_path("sky.exr"), NULL, (float[]){0, 0, 0});
    struct rnd_render *render = make(scene, 16384, "od", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    rnd_render_batch(render, &aim, 1, 96000, &batch);
    assert_int_equal(rnd_render_levels(render), 8);
    uint64_t paths = 0;
    for (int x = 0; x < 2; x++) {
        float rgb[RND_TILE * RND_TILE * 3];
        struct rnd_tile tile;
        assert_true(rnd_render_read(render, 7, x, 0, rgb, &tile));
        paths += tile.samples;
        for (int i = 0; i < RND_TILE * RND_TILE; i++) {
            const int row = i / RND_TILE;
            if (row < 28) assert_float_equal(rgb[3 * i], 1, 1e-6);
            if (row >= 36 && row < 60) /* the speck is below */
                assert_float_equal(rgb[3 * i], 0.125, 1e-6);
        }
    }
    assert_int_equal(paths, 96000);
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
}

/* After the outline, every cell of 16 x 16 pixels has exactly one path. */
static void outline(void **state)
{
    (void)state;
    static float samples[PIXELS];
    int cell[PIXELS / 256] = {0};
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    rnd_render_outline(render, &aim, 1, &batch);
    assert_int_equal(batch.paths, PIXELS / 256);
    rnd_render_resolve(render, NULL, samples, NULL);
    for (int i = 0; i < PIXELS; i++) cell[i / WIDTH / 16 * (WIDTH / 16) + i % WIDTH / 16] += (int)samples[i];
    for (int i = 0; i < PIXELS / 256; i++) assert_int_equal(cell[i], 1);
    rnd_render_destroy(render);
}

/* --- judging --- */

/* A constant world has no error at all. Still, nothing is converged before every pixel has 16 paths. */
static void converged(void **state)
{
    (void)state;
    enum { W = 128, H = 64 };
    static float samples[W * H];
    files_text("speck.mtl", "newmtl m\nKd 0 0 0\n");
    const char *path =
        files_text("far.obj", "mtllib speck.mtl\nusemtl m\nv 0 -9 0\nv 1e-4 -9 0\nv 0 -9 1e-4\nf 1 2 3\n");
    struct rnd_scene *scene = files_load(path, files_env("half.exr", 0.5f), NULL, (float[]){0, 0, 0});
    struct rnd_render *render = make(scene, W, "od", 1);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    struct rnd_tile tiles[2];
    bool seen = false;
    for (int i = 0; i < 100 && !seen; i++) {
        rnd_render_batch(render, &aim, 1, 8000, &batch);
        rnd_render_resolve(render, NULL, samples, NULL);
        rnd_render_tiles(render, tiles);
        for (int t = 0; t < 2; t++) {
            float least = INFINITY;
            for (int k = 0; k < W * H; k++)
                if (k % W / RND_TILE == t) least = fminf(least, samples[k]);
            if (tiles[t].converged) assert_true(least >= 16);
            if (least < 16) assert_false(tiles[t].converged);
            if (tiles[t].samples > 8192)
                assert_true(tiles[t].error < 1e-6f && fabsf(tiles[t].luminance - 0.5f) < 1e-4f);
        }
        seen = tiles[0].converged && tiles[1].converged;
    }
    assert_true(seen);
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
}

/* The error that is estimated from the half-buffers agrees with the true error, measured against a picture
 * with many more paths. */
static void error_is_true(void **state)
{
    (void)state;
    enum { W = 128, H = 64 };
    static float few[3 * W * H], many[3 * W * H], stated[W * H];
    struct rnd_render *render = make(room, W, "od", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    for (int i = 0; i < 16; i++) rnd_render_batch(render, &aim, 1, W * H, &batch);
    rnd_render_resolve(render, few, NULL, stated);
    for (int i = 0; i < 10; i++) rnd_render_batch(render, &aim, 1, 16 * W * H, &batch);
    rnd_render_resolve(render, many, NULL, NULL);
    rnd_render_destroy(render);
    double measured = 0.0, by_halves = 0.0;
    for (int i = 0; i < W * H; i++) {
        const double d = 0.2126 * (few[3 * i] - many[3 * i]) + 0.7152 * (few[3 * i + 1] - many[3 * i + 1]) +
                         0.0722 * (few[3 * i + 2] - many[3 * i + 2]);
        measured += d * d;
        by_halves += (double)stated[i] * stated[i];
    }
    print_message("root mean square error %.4f, by half-buffers %.4f\n", sqrt(measured / (W * H)),
                  sqrt(by_halves / (W * H)));
    /* Caustics have heavy tails, which make both errors imprecise; and the points of the half-buffers are
     * better than random. */
    assert_true(by_halves > 0.6 * measured && by_halves < 2.5 * measured);
}

/* Thresholds by Geisler and Perry 1998 at 20 pixels per degree. The table is for contrast 1; the renderer
 * takes half of them. */
static void visible_error(void **state)
{
    (void)state;
    static const float table[][2] = {{0, .042f},  {5, .132f},  {10, .222f}, {20, .402f},
                                     {30, .583f}, {40, .763f}, {55, 1.04f}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        assert_float_equal(2.0f * rnd_visible_error(table[i][0], 20), table[i][1], i < 1 ? 0.0006 : 0.007);
    /* If the display resolves less than the eye, its own finest wave counts. */
    const double f = 2.5, expected = 0.5 * 5 / (64 * sqrt(1.5 * M_PI) * f * exp(-0.106 * f));
    assert_float_equal(rnd_visible_error(0, 5), expected, 1e-5);
}

/* METHODS: by the same model of the eye, noise that flickers at 5 Hz must be 2.1 to 2.2 times smaller than
 * noise that stands still, whose thresholds at 20 pixels per degree are these. */
static void visible_flicker(void **state)
{
    (void)state;
    static const float standing[][2] = {{0, .046f},  {5, .077f},  {10, .102f}, {20, .142f},
                                        {30, .175f}, {40, .205f}, {55, .245f}};
    for (size_t i = 0; i < sizeof standing / sizeof *standing; i++) {
        const float ratio = standing[i][1] / (2.0f * rnd_visible_flicker(standing[i][0], 20));
        assert_true(ratio > 2.05f && ratio < 2.25f);
    }
    assert_float_equal(rnd_visible_flicker(15, 20), 0.5f * .055f, 1e-6); /* between two rows */
    assert_float_equal(rnd_visible_flicker(10, 5), 0.25f * rnd_visible_flicker(10, 20), 1e-7);
    assert_true(rnd_visible_flicker(180, 20) == rnd_visible_flicker(55, 20));
}

static void settled(void **state)
{
    (void)state;
    struct rnd_render *render = make(room, WIDTH, "od", 1);
    const float ppd = WIDTH / 360.0f;
    const struct rnd_aim ahead = files_aim(0, 0, -1), behind = files_aim(0, 0, 1);
    struct rnd_tile tile = {.samples = 1, .sure_error = 1.01f * rnd_visible_error(0, ppd)};
    /* Tile (4, 2) touches the middle of the film, which is forward. */
    assert_false(rnd_tile_settled(render, &tile, 4, 2, ahead.gaze));
    assert_true(rnd_tile_settled(render, &tile, 4, 2, behind.gaze));
    assert_false(rnd_tile_settled(render, &tile, 0, 2, behind.gaze)); /* across the seam */
    /* a gaze inside tile (4, 2), near the middle of one of its edges */
    float inside[3];
    rnd_direction(3.0f * (float)M_PI / 180, -22.5f * (float)M_PI / 180, inside);
    assert_false(rnd_tile_settled(render, &tile, 4, 2, inside));
    tile.sure_error *= 0.98f;
    assert_true(rnd_tile_settled(render, &tile, 4, 2, ahead.gaze));
    assert_true(rnd_tile_settled(render, &tile, 4, 2, inside));
    tile.unvisited = 1;
    assert_false(rnd_tile_settled(render, &tile, 4, 2, ahead.gaze));
    rnd_render_destroy(render);
}

/* --- files --- */

static bool file_holds(const char *path, const char *what)
{
    static char bytes[20000];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    return memmem(bytes, n, what, strlen(what)) != NULL;
}

static void save(void **state)
{
    (void)state;
    static struct film film;
    char error[RND_ERROR_SIZE];
    int width, height;
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    const uint64_t paths = look_around(render, 5, 10000);
    rnd_render_resolve(render, film.rgb, film.samples, film.error);
    const char *path = files_path("film.exr");
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(rnd_render_save(render, file, path, &(struct rnd_exposure){0}, error));
    assert_int_equal(fclose(file), 0);
    assert_true(file_holds(path, "envmap"));

    float *rgb = rnd_image_read(path, &width, &height, NULL, error);
    assert_non_null(rgb);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    for (int i = 0; i < 3 * PIXELS; i++) assert_float_equal(rgb[i], film.rgb[i], 1e-3 * film.rgb[i] + 1e-7);
    free(rgb);
    float *samples = rnd_image_read_channel(path, "samples", &width, &height, error);
    assert_non_null(samples);
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++) sum += samples[i];
    assert_float_equal(sum, (double)paths, 0);
    assert_memory_equal(samples, film.samples, sizeof film.samples);
    free(samples);
    float *spread = rnd_image_read_channel(path, "error", &width, &height, error);
    assert_non_null(spread);
    for (int i = 0; i < PIXELS; i++)
        assert_float_equal(spread[i], film.error[i], 1e-3 * film.error[i] + 1e-7);
    free(spread);

    assert_null(rnd_image_read_channel(path, "depth", &width, &height, error));
    assert_non_null(strstr(error, "film.exr"));
    assert_non_null(strstr(error, "\"depth\""));
    rnd_render_destroy(render);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels),         cmocka_unit_test(empty_tiles),   cmocka_unit_test(sizes),
        cmocka_unit_test(coarsest_level), cmocka_unit_test(outline),       cmocka_unit_test(converged),
        cmocka_unit_test(error_is_true),  cmocka_unit_test(visible_error), cmocka_unit_test(visible_flicker),
        cmocka_unit_test(settled),        cmocka_unit_test(save),
    };
    return cmocka_run_group_tests_name("renderer_film", tests, setup, teardown);
}
