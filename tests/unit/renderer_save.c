/* What is saved of a film: channels, and planes whose values are known. */
#include "renderer_room.h"

#include "math/half.h"
#include "render.h"

static struct rnd_render *make_with_planes(const struct rnd_scene *scene, uint32_t planes)
{
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .threads = 2,
                                               .seed = 42,
                                               .distribution = rnd_distribution_find("od"),
                                               .planes = planes};
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    return render;
}

static const char *save_as(struct rnd_render *render, const char *name)
{
    const char *path = files_path(name);
    char error[RND_ERROR_SIZE];
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    if (!rnd_render_save(render, file, path, error)) fail_msg("%s", error);
    assert_int_equal(fclose(file), 0);
    return path;
}

/* --- channels --- */

enum { ALL = (1u << RND_PLANES) - 1 };

/* Channels of a whole film, each as a picture. */
struct channels {
    int count;
    const char *name[RND_MOST_CHANNELS];
    float value[RND_MOST_CHANNELS][PIXELS];
};

static void read_all(struct rnd_render *render, struct channels *out)
{
    static float tile[RND_TILE * RND_TILE * RND_MOST_CHANNELS];
    struct rnd_tile state, states[TILES];
    for (out->count = 0; rnd_render_channel(render, out->count); out->count++)
        out->name[out->count] = rnd_render_channel(render, out->count);
    assert_true(out->count <= RND_MOST_CHANNELS);
    rnd_render_tiles(render, states);
    for (int t = 0; t < TILES; t++) {
        const int across = WIDTH / RND_TILE;
        assert_true(rnd_render_read_channels(render, t % across, t / across, tile, &state));
        assert_int_equal(state.samples, states[t].samples);
        for (int i = 0; i < RND_TILE * RND_TILE; i++)
            for (int c = 0; c < out->count; c++)
                out->value[c][(t / across * RND_TILE + i / RND_TILE) * WIDTH + t % across * RND_TILE +
                              i % RND_TILE] = tile[i * out->count + c];
    }
}

static const float *channel(const struct channels *channels, const char *name)
{
    for (int c = 0; c < channels->count; c++)
        if (!strcmp(channels->name[c], name)) return channels->value[c];
    fail_msg("no channel %s", name);
    return NULL;
}

/* A square of 4 x 4 m below the camera, under a white sky, so far from the origin that halves end before it
 * and floats have steps of a centimetre. */
static const double MIDDLE[3] = {200000, -1, -70000};
static const float CAMERA[3] = {200000.5f, 0.5f, -70000.25f}, ALBEDO[3] = {0.25f, 0.5f, 0.75f};

static struct rnd_scene *load_square(void)
{
    const char *path =
        files_gltf("square.gltf", 2, "{\"mesh\":0,\"translation\":[200000,-1,-70000]}",
                   "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[0.25,0.5,"
                   "0.75,1]}}",
                   "");
    struct rnd_scene *scene = files_load(path, files_env("white.exr", 1), NULL, CAMERA);
    assert_true(scene->origin[0] > 100000); /* its own coordinates are others than those of the world */
    return scene;
}

/* Where on the square pixel i lies, in m from its middle. False if the pixel shows the sky, or its edge. */
static bool hit(int i, double out[3])
{
    const double a = ((i % WIDTH + 0.5) / WIDTH - 0.5) * 2 * M_PI,
                 e = (0.5 - (i / WIDTH + 0.5) / HEIGHT) * M_PI;
    const double d[3] = {cos(e) * sin(a), sin(e), -cos(e) * cos(a)};
    if (d[1] > -0.1) return false;
    const double t = (MIDDLE[1] - (double)CAMERA[1]) / d[1];
    for (int k = 0; k < 3; k++) out[k] = (double)CAMERA[k] - MIDDLE[k] + t * d[k];
    return fabs(out[0]) < 1.9 && fabs(out[2]) < 1.9;
}

static void planes(void **state)
{
    (void)state;
    static struct channels seen;
    static const char *const names[] = {
        "R",        "G",        "B",        "samples",    "error",      "albedo.R",   "albedo.G", "albedo.B",
        "normal.X", "normal.Y", "normal.Z", "position.X", "position.Y", "position.Z", "coverage", "instance"};
    struct rnd_scene *scene = load_square();
    struct rnd_render *render = make_with_planes(scene, ALL);
    look_around(render, 8, PIXELS / 2);
    read_all(render, &seen);
    assert_int_equal(seen.count, sizeof names / sizeof *names);
    for (int c = 0; c < seen.count; c++) assert_string_equal(seen.name[c], names[c]);
    const float *albedo = channel(&seen, "albedo.R"), *normal = channel(&seen, "normal.X"),
                *position = channel(&seen, "position.X"), *coverage = channel(&seen, "coverage"),
                *instance = channel(&seen, "instance"), *samples = channel(&seen, "samples");
    int inside = 0, edge = 0, sky = 0, empty = 0;
    for (int i = 0; i < PIXELS; i++) {
        double at[3];
        if (samples[i] == 0) {
            for (int c = 0; c < seen.count; c++) assert_true(seen.value[c][i] == 0);
            empty++;
        } else if (coverage[i] == 0) {
            for (int c = 5; c < seen.count; c++) assert_true(seen.value[c][i] == 0);
            assert_false(hit(i, at));
            sky++;
        } else {
            for (int k = 0; k < 3; k++) {
                assert_float_equal(albedo[k * PIXELS + i], ALBEDO[k] * coverage[i], 1e-3);
                assert_float_equal(normal[k * PIXELS + i], k == 1 ? coverage[i] : 0, 1e-3);
            }
            /* halves keep the coverage, to a part in 2048 */
            assert_float_equal(position[PIXELS + i], MIDDLE[1] * (double)coverage[i], 1e-3);
            edge += coverage[i] < 1;
        }
        if (samples[i] == 0 || !hit(i, at)) continue;
        assert_true(coverage[i] == 1 && instance[i] == 1);
        for (int k = 0; k < 3; k += 2) /* within about a pixel */
            assert_float_equal((double)position[k * PIXELS + i] - MIDDLE[k], at[k], 0.15);
        inside++;
    }
    print_message("pixels of the square %d, of its edge %d, of the sky %d, without paths %d\n", inside, edge,
                  sky, empty);
    assert_true(inside > 10000 && edge > 100 && sky > 50000 && empty > 100);

    /* the file has the same values: those of planes bit for bit */
    const char *path = save_as(render, "planes.exr");
    for (int c = 0; c < seen.count; c++) {
        char error[RND_ERROR_SIZE];
        int width, height;
        float *saved = rnd_image_read_channel(path, seen.name[c], &width, &height, error);
        if (!saved) fail_msg("%s", error);
        assert_true(width == WIDTH && height == HEIGHT);
        for (int i = 0; i < PIXELS; i++)
            assert_float_equal(
                saved[i], c < 5 ? rnd_half_decode(rnd_half_encode(seen.value[c][i])) : seen.value[c][i], 0);
        free(saved);
    }
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
}

/* Planes change nothing else; and a film without them has no memory for them, as well as no channels. */
static void planes_apart(void **state)
{
    (void)state;
    static struct channels seen[2];
    for (int k = 0; k < 2; k++) {
        struct rnd_render *render = make_with_planes(room, k ? ALL : 0);
        look_around(render, 5, 20000);
        read_all(render, &seen[k]);
        assert_int_equal(render->film.planes.bytes, k ? 30 : 0);
        assert_int_equal(render->film.plane_memory != NULL, k);
        rnd_render_destroy(render);
    }
    assert_int_equal(seen[0].count, 5);
    for (int c = 0; c < 5; c++)
        assert_memory_equal(seen[0].value[c], seen[1].value[c], sizeof seen[0].value[c]);
    /* some of them: positions need coverage */
    struct rnd_render *render = make_with_planes(room, RND_PLANE(POSITION));
    assert_string_equal(rnd_render_channel(render, 5), "position.X");
    assert_string_equal(rnd_render_channel(render, 8), "coverage");
    assert_null(rnd_render_channel(render, 9));
    rnd_render_destroy(render);
}

/* What is read tile by tile is what is read as a whole. */
static void own_channels(void **state)
{
    (void)state;
    static struct channels seen;
    static struct film film;
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    for (int turn = 0; turn < 3; turn++) { /* empty; with the outline; with more */
        if (turn == 1) rnd_render_outline(render, &aim, 1, &batch);
        if (turn == 2) look_around(render, 5, 20000);
        read_all(render, &seen);
        rnd_render_resolve(render, film.rgb, film.samples, film.error);
        for (int i = 0; i < PIXELS; i++) {
            for (int c = 0; c < 3; c++) assert_true(seen.value[c][i] == film.rgb[3 * i + c]);
            assert_true(seen.value[3][i] == film.samples[i] && seen.value[4][i] == film.error[i]);
        }
    }
    rnd_render_destroy(render);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(planes), cmocka_unit_test(planes_apart),
                                       cmocka_unit_test(own_channels)};
    return cmocka_run_group_tests_name("renderer_save", tests, setup, teardown);
}
