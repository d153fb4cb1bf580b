/* What is saved of a film: channels and planes whose values are known, pictures for displays, and what marks
 * a file as a panorama. */
#include "renderer_room.h"

#include "math/half.h"
#include "math/srgb.h"
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

static const char *save_as(struct rnd_render *render, const char *name, struct rnd_exposure exposure)
{
    const char *path = files_path(name);
    char error[RND_ERROR_SIZE];
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    if (!rnd_render_save(render, file, path, &exposure, error)) fail_msg("%s", error);
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
    const char *path = save_as(render, "planes.exr", (struct rnd_exposure){0});
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

/* --- pictures for displays --- */

static float *read_picture(const char *path)
{
    char error[RND_ERROR_SIZE];
    int width, height;
    float *rgb = rnd_image_read(path, &width, &height, NULL, error);
    if (!rgb) fail_msg("%s", error);
    assert_true(width == WIDTH && height == HEIGHT);
    return rgb;
}

/* A picture has what clients are shown, which has no holes, brighter by the exposure. */
static void pictures(void **state)
{
    (void)state;
    static const struct rnd_exposure exposures[] = {{0}, {.stops = 2}, {.stops = -3}};
    static float shown[3 * PIXELS], tile[RND_TILE * RND_TILE * 3];
    struct rnd_render *render = make(room, WIDTH, "fv", 2);
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    int holes = 0, dark = 0;
    rnd_render_outline(render, &aim, 1, &batch);
    rnd_render_batch(render, &aim, 1, 30000, &batch);
    for (int t = 0; t < TILES; t++) {
        const int left = t % (WIDTH / RND_TILE) * RND_TILE, top = t / (WIDTH / RND_TILE) * RND_TILE;
        assert_true(rnd_render_read(render, 0, left / RND_TILE, top / RND_TILE, tile, NULL));
        for (int y = 0; y < RND_TILE; y++)
            memcpy(&shown[3 * ((top + y) * WIDTH + left)], &tile[3 * RND_TILE * y],
                   3 * RND_TILE * sizeof *tile);
    }
    for (size_t k = 0; k < sizeof exposures / sizeof *exposures; k++) {
        float *png = read_picture(save_as(render, "shown.png", exposures[k])),
              *jpg = read_picture(save_as(render, "shown.JPG", exposures[k]));
        double apart = 0;
        for (int i = 0; i < 3 * PIXELS; i++) {
            const double expected = (double)rnd_srgb_encode(shown[i] * exp2f((float)exposures[k].stops));
            assert_float_equal(rnd_srgb_encode(png[i]), expected, 0.51 / 255);
            apart += fabs((double)rnd_srgb_encode(jpg[i]) - expected);
        }
        assert_true(apart / (3 * PIXELS) < 0.03); /* the noise of a few paths is hard for a JPEG */
        free(png);
        free(jpg);
    }
    static float samples[PIXELS];
    rnd_render_resolve(render, NULL, samples, NULL);
    for (int i = 0; i < PIXELS; i++) holes += samples[i] == 0;
    for (int i = 0; i < PIXELS; i++) dark += shown[3 * i] + shown[3 * i + 1] + shown[3 * i + 2] <= 0;
    print_message("%d pixels have no path, %d are shown black\n", holes, dark);
    assert_true(holes > PIXELS / 2 && dark < PIXELS / 20);

    /* automatic: half of the sphere, by solid angle, is above middle grey; by blocks, as pixels are noisy */
    float *rgb = read_picture(save_as(render, "auto.png", (struct rnd_exposure){.automatic = true}));
    double above = 0, all = 0;
    for (int b = 0; b < PIXELS / 1024; b++) {
        const int x = b % (WIDTH / 32) * 32, y = b / (WIDTH / 32) * 32;
        const double weight = cos(((y + 16.0) / HEIGHT - 0.5) * M_PI);
        double sum = 0;
        for (int p = 0; p < 1024; p++) {
            const float *c = &rgb[3 * ((y + p / 32) * WIDTH + x + p % 32)];
            sum += 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
        }
        above += sum / 1024 > 0.17 ? weight : 0; /* bright pixels are clipped, which darkens blocks */
        all += weight;
    }
    print_message("%.0f %% of the sphere are above middle grey\n", 100 * above / all);
    assert_true(above / all > 0.35 && above / all < 0.65);
    free(rgb);
    rnd_render_destroy(render);
}

/* --- marks of panoramas --- */

static uint8_t bytes[1 << 20];

static size_t read_bytes(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t count = fread(bytes, 1, sizeof bytes, file);
    assert_true(count < sizeof bytes);
    fclose(file);
    return count;
}

static uint32_t big_endian(const uint8_t *from, int count)
{
    uint32_t value = 0;
    for (int i = 0; i < count; i++) value = value << 8 | from[i];
    return value;
}

/* Google's Photo Sphere XMP metadata of a whole panorama of 64 x 32 pixels. */
static void assert_gpano(const char *xmp, size_t count)
{
    static const char *const properties[] = {"UsePanoramaViewer=\"True\"",
                                             "ProjectionType=\"equirectangular\"",
                                             "PoseHeadingDegrees=\"0\"",
                                             "FullPanoWidthPixels=\"64\"",
                                             "FullPanoHeightPixels=\"32\"",
                                             "CroppedAreaImageWidthPixels=\"64\"",
                                             "CroppedAreaImageHeightPixels=\"32\"",
                                             "CroppedAreaLeftPixels=\"0\"",
                                             "CroppedAreaTopPixels=\"0\""};
    static const char name[] = "xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"";
    assert_true(count > 12 && !memcmp(xmp, "<?xpacket", 9) && !memcmp(xmp + count - 2, "?>", 2));
    assert_non_null(memmem(xmp, count, name, strlen(name)));
    for (size_t i = 0; i < sizeof properties / sizeof *properties; i++) {
        char text[64];
        snprintf(text, sizeof text, " GPano:%s", properties[i]);
        if (!memmem(xmp, count, text, strlen(text))) fail_msg("no%s in %.*s", text, (int)count, xmp);
    }
}

/* Find the XMP of a PNG: the second chunk. NULL if that is none. All chunks must be in form. */
static const char *png_xmp(size_t count, size_t *out_count)
{
    static const char head[] = "XML:com.adobe.xmp\0\0\0\0"; /* and one more */
    static uint8_t again[sizeof bytes];
    const char *found = NULL;
    int number = 0;
    size_t at = 8;
    for (; at + 12 <= count; number++) {
        const uint32_t size = big_endian(bytes + at, 4);
        char type[5] = "";
        assert_true(size <= count - at - 12);
        memcpy(type, bytes + at + 4, 4);
        assert_int_equal(files_chunk(again, type, bytes + at + 8, size), size + 12);
        assert_memory_equal(again, bytes + at, size + 12); /* with its checksum */
        if (number == 0) assert_string_equal(type, "IHDR");
        if (!strcmp(type, "iTXt")) {
            assert_int_equal(number, 1);
            assert_memory_equal(bytes + at + 8, head, sizeof head);
            found = (const char *)bytes + at + 8 + sizeof head;
            *out_count = size - sizeof head;
        }
        at += size + 12;
    }
    assert_int_equal(at, count);
    return found;
}

/* Find the XMP of a JPEG: one of its segments APP1. */
static const char *jpeg_xmp(size_t count, size_t *out_count)
{
    static const char head[] = "http://ns.adobe.com/xap/1.0/"; /* with its end */
    for (size_t at = 2; at + 4 < count && bytes[at] == 0xff && bytes[at + 1] != 0xda;) {
        const uint32_t size = big_endian(bytes + at + 2, 2);
        assert_true(size >= 2 && size <= count - at - 2);
        if (bytes[at + 1] == 0xe1 && size > 2 + sizeof head && !memcmp(bytes + at + 4, head, sizeof head)) {
            *out_count = size - 2 - sizeof head;
            return (const char *)bytes + at + 4 + sizeof head;
        }
        at += 2 + size;
    }
    return NULL;
}

static void panoramas(void **state)
{
    (void)state;
    enum { W = 64, H = 32 };
    static const char envmap[] = "envmap\0envmap\0\1\0\0\0"; /* and one byte, 0: latitude and longitude */
    static float rgb[3 * W * H];
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < 3 * W * H; i++) rgb[i] = (float)i / (3 * W * H);
    for (int marked = 0; marked < 2; marked++) {
        static const char *const names[] = {"a.png", "a.PNG", "a.jpg", "a.jpeg"};
        for (int k = 0; k < 4; k++) {
            const char *path = files_path(names[k]);
            size_t size = 0;
            if (!files_image(path, W, H, rgb, marked, error)) fail_msg("%s", error);
            const size_t count = read_bytes(path);
            const char *xmp = k < 2 ? png_xmp(count, &size) : jpeg_xmp(count, &size);
            if (marked && !xmp) fail_msg("%s is not marked", names[k]);
            if (marked)
                assert_gpano(xmp, size);
            else
                assert_true(!xmp && !memmem(bytes, count, "GPano", 5));
            float *back = rnd_image_read(path, &(int){0}, &(int){0}, NULL, error);
            if (!back) fail_msg("%s", error);
            free(back);
        }
        if (!files_image(files_path("a.exr"), W, H, rgb, marked, error)) fail_msg("%s", error);
        const size_t count = read_bytes(files_path("a.exr"));
        assert_int_equal(memmem(bytes, count, envmap, sizeof envmap) != NULL, marked);
    }
}

/* The same picture is the same file, whatever the time of day and the letters of its name. */
static void same_file(void **state)
{
    (void)state;
    enum { KINDS = 3 };
    static uint8_t first[KINDS][sizeof bytes / 8];
    static size_t size[KINDS];
    static float rgb[3 * 64 * 32];
    static const char *const names[2][KINDS] = {{"b.exr", "b.png", "b.jpg"}, {"b.EXR", "b.Png", "b.JPG"}};
    char error[RND_ERROR_SIZE];
    for (int turn = 0; turn < 2; turn++) {
        if (turn > 0) sleep(1); /* a date in the file would be another one */
        for (int k = 0; k < KINDS; k++) {
            const char *path = files_path(names[turn][k]);
            if (!files_image(path, 64, 32, rgb, true, error)) fail_msg("%s", error);
            const size_t count = read_bytes(path);
            assert_true(count <= sizeof first[k]);
            if (turn == 0) memcpy(first[k], bytes, size[k] = count);
            assert_int_equal(count, size[k]);
            assert_memory_equal(bytes, first[k], count);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes),   cmocka_unit_test(planes_apart), cmocka_unit_test(own_channels),
        cmocka_unit_test(pictures), cmocka_unit_test(panoramas),    cmocka_unit_test(same_file),
    };
    return cmocka_run_group_tests_name("renderer_save", tests, setup, teardown);
}
