/* fovead's command line, when a render is done, and small functions that both programs share. */
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "daemon.h"
#include "options.h"

/* What parse() last printed to stderr. */
static char said[4096];

static enum dmn_parsed parse(const char *line, struct dmn_options *out)
{
    char copy[512], *argv[40] = {"fovead"}, *save = NULL;
    int argc = 1, kept = dup(STDERR_FILENO);
    FILE *file = tmpfile();
    enum dmn_parsed parsed;

    /* The parsed options point into this copy of the line. */
    char *words = strdup(line);
    snprintf(copy, sizeof(copy), "%s", line);
    for (char *word = strtok_r(words, " ", &save); word; word = strtok_r(NULL, " ", &save))
        argv[argc++] = word;
    dup2(fileno(file), STDERR_FILENO);
    parsed = dmn_options_parse(argc, argv, out);
    fflush(stderr);
    dup2(kept, STDERR_FILENO);
    close(kept);
    rewind(file);
    said[fread(said, 1, sizeof(said) - 1, file)] = '\0';
    fclose(file);
    if (parsed != DMN_RUN) free(words);
    return parsed;
}

static void run(const char *line, struct dmn_options *out)
{
    enum dmn_parsed parsed = parse(line, out);

    if (parsed != DMN_RUN) fail_msg("%s: %s", line, said);
}

static void finish(struct dmn_options *options)
{
    /* Free the line, whose first word is always --scene. */
    free((char *)(uintptr_t)(options->scene.path - strlen("--scene ")));
}

static void defaults(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a.gltf", &o);
    assert_string_equal(o.scene.path, "a.gltf");
    assert_int_equal(o.render.width, 4096);
    assert_int_equal(o.render.height, 2048);
    assert_string_equal(o.gaze, "auto");
    assert_string_equal(o.render.distribution->name, "fv");
    assert_false(o.watch);
    assert_false(o.has_viewer);
    assert_int_equal(o.listens, 1);
    assert_true(o.listen[0].is_unix);
    assert_int_equal(o.until.kind, DMN_UNTIL_STOPPED);
    finish(&o);
}

static void a_final_picture(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a.gltf --until 256spp --save b.exr", &o);
    assert_null(o.gaze);
    assert_string_equal(o.render.distribution->name, "od");
    assert_int_equal(o.listens, 0);
    assert_int_equal(o.until.kind, DMN_UNTIL_PATHS);
    assert_true(o.until.amount == 256);
    finish(&o);
    run("--scene a.gltf --until 2.5s --gaze synthetic:3", &o);
    assert_string_equal(o.render.distribution->name, "fv");
    finish(&o);
    run("--scene a.gltf --until end", &o);
    assert_string_equal(o.gaze, "auto");
    finish(&o);
    run("--scene a.gltf --clock virtual --gaze replay:x", &o);
    assert_int_equal(o.until.kind, DMN_UNTIL_END);
    assert_int_equal(o.listens, 0);
    finish(&o);
}

static void everything_said(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a.obj --env e.hdr --sun -30,45.5,3,0.53 --camera -1,2,3.5 --gaze replay:g --speed 2 --loop "
        "--mode vp "
        "--fov 90,80 --size 1024x512 --threads 3 --seed 18446744073709551615 --bounces 7 --clamp 2.5 "
        "--clear-glass --listen unix:/a/b "
        "--listen tcp:127.0.0.1:9 --listen http:127.0.0.1:10 --tls a/c.pem,k.pem --json --watch",
        &o);
    assert_true(o.watch);
    assert_string_equal(o.scene.env_path, "e.hdr");
    assert_true(o.scene.has_sun && o.scene.sun[0] == -30 && o.scene.sun[1] == 45.5f &&
                o.scene.sun[3] == 0.53f);
    assert_true(o.scene.has_camera && o.scene.camera[0] == -1 && o.scene.camera[2] == 3.5f);
    assert_true(o.speed == 2 && o.loop && o.json);
    assert_true(fabsf(o.fov[0] - (float)M_PI / 2) < 1e-6f);
    assert_int_equal(o.render.width, 1024);
    assert_int_equal(o.render.threads, 3);
    assert_true(o.render.seed == UINT64_MAX);
    assert_int_equal(o.render.max_bounces, 7);
    assert_float_equal(o.render.firefly, 2.5, 0);
    assert_true(o.scene.clear_glass);
    assert_int_equal(o.listens, 3);
    assert_int_equal(o.listen[1].port, 9);
    assert_string_equal(o.tls_certificate, "a/c.pem");
    assert_string_equal(o.tls_key, "k.pem");
    finish(&o);
}

static void saving(void **state)
{
    static const struct {
        const char *line;
        uint32_t planes;
    } PLANES[] = {{"", 0},
                  {"--planes albedo", 1},
                  {"--planes instance,normal", 18},
                  {"--planes all", 31},
                  {"--planes all --planes position,position", 4}};
    struct dmn_options o;

    (void)state;
    run("--scene a.gltf --save b.JPEG --save-every 2.5 --exposure -1.5", &o);
    assert_string_equal(o.save, "b.JPEG");
    assert_true(o.save_every == 2.5 && o.exposure.stops == -1.5 && !o.exposure.automatic);
    finish(&o);
    run("--scene a.gltf --save b.png --exposure auto", &o);
    assert_true(o.save_every == 0 && o.exposure.automatic);
    finish(&o);
    for (size_t i = 0; i < sizeof(PLANES) / sizeof(*PLANES); i++) {
        char line[100];

        snprintf(line, sizeof(line), "--scene a.gltf %s", PLANES[i].line);
        run(line, &o);
        assert_int_equal(o.render.planes, PLANES[i].planes);
        finish(&o);
    }
    assert_int_equal(parse("--scene a.gltf --planes normal,depth", &o), DMN_REFUSED);
    assert_non_null(strstr(said, "there is no 'depth', expected all or some of "
                                 "albedo,normal,position,coverage,instance"));
    assert_int_equal(parse("--scene a.gltf --save b.tiff", &o), DMN_REFUSED);
    assert_non_null(strstr(said, "wants a name that ends in .exr, .png or .jpg"));
}

static void the_former_name_of_camera(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a.obj --camera 4,5,6 --eye -1,2,3.5", &o);
    assert_true(o.scene.has_camera && o.scene.camera[0] == -1 && o.scene.camera[1] == 2 &&
                o.scene.camera[2] == 3.5);
    finish(&o);
}

static void gaze(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a.obj --gaze hid:/dev/hidraw3 --screen 0.6,0.34,0.7 --raw-gaze --predict --record g.gaze "
        "--replace",
        &o);
    assert_true(o.screen.width_m == 0.6f && o.screen.height_m == 0.34f && o.screen.distance_m == 0.7f);
    assert_true(o.raw_gaze && o.predict && o.replace);
    assert_string_equal(o.record, "g.gaze");
    finish(&o);
    run("--scene a.obj --gaze psvr2 --calibration c.bin", &o);
    assert_string_equal(o.calibration, "c.bin");
    assert_false(o.raw_gaze || o.predict || o.record);
    finish(&o);
    run("--scene a.obj --screen 1,1,1 --calibration c.bin", &o); /* auto may be either */
    finish(&o);
    assert_int_equal(parse("--list-trackers", &o), DMN_LIST);
    assert_int_equal(parse("--json --list-trackers", &o), DMN_LIST);
    assert_true(o.json);
}

static void viewer(void **state)
{
    static const struct {
        const char *line, *host;
        int port;
    } GOOD[] = {
        {"--scene a --tev 127.0.0.1", "127.0.0.1", 14158},
        {"--scene a --tev studio.example", "studio.example", 14158},
        {"--scene a --tev localhost:7", "localhost", 7},
        {"--scene a --tev [::1]", "::1", 14158},
        {"--scene a --tev [::1]:65535", "::1", 65535},
    };

    (void)state;
    for (size_t i = 0; i < sizeof(GOOD) / sizeof(*GOOD); i++) {
        struct dmn_options o;

        run(GOOD[i].line, &o);
        assert_true(o.has_viewer && !o.viewer.is_unix);
        assert_string_equal(o.viewer.host, GOOD[i].host);
        assert_int_equal(o.viewer.port, GOOD[i].port);
        finish(&o);
    }
}

static void given_again(void **state)
{
    struct dmn_options o;

    (void)state;
    run("--scene a --mode od --mode vp --fov 90,80 --fov 60,50 --clock virtual --clock real --until end "
        "--until 3s",
        &o);
    assert_string_equal(o.render.distribution->name, "vp");
    assert_true(fabsf(o.fov[0] - (float)M_PI / 3) < 1e-6f);
    assert_false(o.virtual_clock);
    assert_true(o.until.kind == DMN_UNTIL_SECONDS && o.until.amount == 3);
    finish(&o);
    run("--scene a --listen /a --listen /b --listen /c --listen /d --listen /e --listen /f --listen /g "
        "--listen /h",
        &o);
    assert_int_equal(o.listens, 8);
    finish(&o);
    assert_int_equal(
        parse("--scene a --listen /a --listen /b --listen /c --listen /d --listen /e --listen /f "
              "--listen /g --listen /h --listen /i",
              &o),
        DMN_REFUSED);
    assert_string_equal(said, "fovead: --listen: 8 addresses at most; see fovead --help\n");
}

static const char *const REFUSED[] = {
    "",
    "--scene",
    "--scene a --nonsense",
    "--scene a b",
    "--scene a --size 1000x500",
    "--scene a --size 4096x2047",
    "--scene a --size 65536",
    "--scene a --size 0",
    "--scene a --size 128x",
    "--scene a --sun 1,2,3",
    "--scene a --sun 1,2,3,nan",
    "--scene a --sun 1,95,3,0.5",
    "--scene a --sun 1,2,1e300,0.5",
    "--scene a --camera 1,2",
    "--scene a --camera 1,2,3,4",
    "--scene a --camera 1,,3",
    "--scene a --camera 1,2,1e8",
    "--scene a --camera 1e39,2,3",
    "--scene a --watch=1",
    "--scene a --watch --clock virtual --gaze replay:x",
    "--scene a --threads 0",
    "--scene a --threads -1",
    "--scene a --threads 1e3",
    "--scene a --seed 18446744073709551616",
    "--scene a --bounces x",
    "--scene a --env-turn 10",
    "--scene a --env b --env-turn x",
    "--scene a --clamp 0",
    "--scene a --clamp x",
    "--scene a --clamp 1e-60",
    "--scene a --clamp 1e60",
    "--scene a --display-ppd 0",
    "--scene a --mode od --display-ppd 20",
    "--scene a --speed -1",
    "--scene a --speed inf",
    "--scene a --mode nope",
    "--scene a --fov 90,80",
    "--scene a --mode vp --fov 90",
    "--scene a --mode vp --fov 180,90",
    "--scene a --mode vp --fov 179.9999999999,90",
    "--scene a --until 5",
    "--scene a --until 0spp",
    "--scene a --until -3s",
    "--scene a --until 5sppx",
    "--scene a --until converged --mode fv",
    "--scene a --until end --loop",
    "--scene a --until end --gaze synthetic",
    "--scene a --until end --gaze hid",
    "--scene a --clock virtual --gaze pointer --until 1s",
    "--scene a --clock virtual --gaze hid --until 1s",
    "--scene a --clock slow",
    "--scene a --until 1s --loop",
    "--scene a --clock virtual --speed 2",
    "--scene a --save b.tif",
    "--scene a --save png",
    "--scene a --save-every 5",
    "--scene a --save b.exr --save-every 0.5",
    "--scene a --save b.exr --save-every 5 --clock virtual --gaze replay:x",
    "--scene a --exposure 1",
    "--scene a --save b.exr --exposure 1",
    "--scene a --save b.png --exposure 65",
    "--scene a --planes",
    "--scene a --planes=",
    "--scene a --planes albedo,",
    "--scene a --planes albedo,all",
    "--scene a --planes Albedo",
    "--scene a --planes albed",
    "--scene a --listen tcp:localhost",
    "--scene a --listen https:localhost:1 --tls c,k",
    "--scene a --tls c,k",
    "--scene a --listen tcp:localhost:1 --tls c,k",
    "--scene a --listen http:localhost:1 --tls c",
    "--scene a --listen http:localhost:1 --tls c,",
    "--scene a --listen http:localhost:1 --tls ,k",
    "--scene a --listen http:localhost:1 --tls c,k,d",
    "--scene a --tev 14158",
    "--scene a --tev=",
    "--scene a --tev :14158",
    "--scene a --tev localhost:",
    "--scene a --tev localhost:0",
    "--scene a --tev localhost:65536",
    "--scene a --tev localhost:1:2",
    "--scene a --tev ::1",
    "--scene a --tev [::1",
    "--scene a --tev [::1]7",
    "--scene a --tev http://localhost:14158",
    "--scene a --json=1",
    "--scene a --screen 1,2",
    "--scene a --screen 1,2,0",
    "--scene a --screen 1,2,nan",
    "--scene a --screen 1,2,21",
    "--scene a --gaze psvr2 --screen 1,1,1",
    "--scene a --gaze hidden --screen 1,1,1",
    "--scene a --gaze hid --calibration c",
    "--scene a --gaze pointer --predict",
    "--scene a --gaze pointer --raw-gaze",
    "--scene a --until 1s --raw-gaze",
    "--scene a --until 1s --record g",
    "--scene a --replace",
    "--list-trackers --nonsense",
};

static void refused_with_one_line(void **state)
{

    (void)state;
    for (size_t i = 0; i < sizeof(REFUSED) / sizeof(*REFUSED); i++) {
        struct dmn_options o;

        if (parse(REFUSED[i], &o) != DMN_REFUSED) fail_msg("'%s' was not refused", REFUSED[i]);
        if (strncmp(said, "fovead: ", 8) != 0 || strchr(said, '\n') != said + strlen(said) - 1)
            fail_msg("'%s' is refused by: %s", REFUSED[i], said);
    }
}

static void done(void **state)
{
    struct dmn_until until;
    struct dmn_progress p = {.paths = 50, .pixels = 100, .seconds = 3, .tiles = 8, .converged = 2};

    (void)state;
    assert_true(dmn_until_parse("2spp", &until));
    assert_true(dmn_until_share(&until, &p) == 0.25);
    p.paths = 300;
    assert_true(dmn_until_share(&until, &p) == 1);
    assert_true(dmn_until_parse("6s", &until));
    assert_true(dmn_until_share(&until, &p) == 0.5);
    assert_true(dmn_until_parse("converged", &until));
    assert_true(dmn_until_share(&until, &p) == 0.25);
    assert_true(dmn_until_parse("end", &until));
    assert_true(dmn_until_share(&until, &p) == 0);
    p.gaze_ended = true;
    assert_true(dmn_until_share(&until, &p) == 1);
    assert_true(dmn_until_share(&(struct dmn_until){0}, &p) == 0);
}

static void places(void **state)
{
    static const double SOMEWHERE[][3] = {{0, 0, 0}, {-0., 1e-30, 1.6}, {1e7, -1e7, 1e7}};

    (void)state;
    for (int i = 0; i < 3; i++) assert_true(dmn_camera_is_in_range(SOMEWHERE[i]));
    for (int i = 0; i < 3; i++) {
        static const double NOWHERE[] = {NAN, INFINITY, -INFINITY, 1.1e7, -1.1e7, 3e38};

        for (int k = 0; k < 6; k++) {
            double camera[3] = {1, 2, 3};

            camera[i] = NOWHERE[k];
            assert_false(dmn_camera_is_in_range(camera));
        }
    }
}

static void directions(void **state)
{
    static const double ANGLES[][2] = {{0, 0}, {90, 0}, {-120, 45}, {30, -80}, {179, 10}};

    (void)state;
    for (size_t i = 0; i < sizeof(ANGLES) / sizeof(*ANGLES); i++) {
        float d[3], q[4], turned[3], t[3];
        double yaw, pitch;

        rnd_direction((float)(ANGLES[i][0] * M_PI / 180), (float)(ANGLES[i][1] * M_PI / 180), d);
        dmn_angles(d, &yaw, &pitch);
        assert_true(fabs(yaw - ANGLES[i][0]) < 1e-3 && fabs(pitch - ANGLES[i][1]) < 1e-3);
        /* Turning the view's forward direction, -Z, by the quaternion gives d: v + 2 q x (q x v + w v). */
        dmn_orientation(d, q);
        for (int c = 0; c < 3; c++) t[c] = 0;
        t[0] = -q[1], t[1] = q[0], t[2] = -q[3];
        turned[0] = 2 * (q[1] * t[2] - q[2] * t[1]);
        turned[1] = 2 * (q[2] * t[0] - q[0] * t[2]);
        turned[2] = -1 + 2 * (q[0] * t[1] - q[1] * t[0]);
        for (int c = 0; c < 3; c++) assert_true(fabsf(turned[c] - d[c]) < 1e-5f);
    }
}

static void percentiles(void **state)
{
    struct dmn_histogram *h = calloc(1, sizeof(*h));

    (void)state;
    assert_true(dmn_histogram_quantile(h, 0.5) == 0);
    for (int i = 1; i <= 1000; i++) dmn_histogram_add(h, i * 1e-4);
    for (int p = 1; p < 100; p++) {
        double found = dmn_histogram_quantile(h, p / 100.0);

        assert_true(fabs(found / (p * 1e-3) - 1) < 0.03);
    }
    /* Values beyond the range of the histogram, and NaN, are counted too. */
    dmn_histogram_add(h, -1);
    dmn_histogram_add(h, 1e9);
    dmn_histogram_add(h, NAN);
    assert_int_equal(h->count, 1003);
    free(h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults),
        cmocka_unit_test(a_final_picture),
        cmocka_unit_test(everything_said),
        cmocka_unit_test(saving),
        cmocka_unit_test(the_former_name_of_camera),
        cmocka_unit_test(gaze),
        cmocka_unit_test(viewer),
        cmocka_unit_test(given_again),
        cmocka_unit_test(refused_with_one_line),
        cmocka_unit_test(done),
        cmocka_unit_test(places),
        cmocka_unit_test(directions),
        cmocka_unit_test(percentiles),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
