/* fovead-image writes pictures: the files, failures to write, and processes that end meanwhile. */
#include "renderer_files.h"
#include "renderer_parts.h"

#include "import/image_apart.h"
#include "import/image_program.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>

/* A picture whose numbers identify their places, exact in half floats and in 8 bits. */
static const struct rnd_layout wide = {.width = 5000, /* a row is larger than a packet */
                                       .height = 71,
                                       .channels = 5,
                                       .channel = {{"R", RND_HALF},
                                                   {"G", RND_HALF},
                                                   {"B", RND_HALF},
                                                   {"samples", RND_FLOAT},
                                                   {"error", RND_FLOAT}},
                                       .equirectangular = true,
                                       .format = "exr"};

static float at(int x, int y, int c)
{
    return (float)((x * 31 + y * 17 + c * 5) % 256) / 255.0f;
}

struct numbers {
    struct rnd_pixels_source source; /* first */
    const struct rnd_layout *layout;
    void (*meanwhile)(void); /* called once the writer has the first row; or NULL */
    int rows;                /* asked for so far */
};

static void number_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    struct numbers *numbers = (struct numbers *)(void *)source;
    const struct rnd_layout *layout = numbers->layout;
    if (first == 0) numbers->rows = 0;
    assert_int_equal(first, numbers->rows);
    numbers->rows += count;
    if (first == 1 && numbers->meanwhile) numbers->meanwhile();
    for (int y = first; y < first + count; y++)
        for (int x = 0; x < layout->width; x++)
            for (int c = 0; c < layout->channels; c++) *out_pixels++ = at(x, y, c);
}

static bool write_apart(struct rnd_image_program *program, int fd, const struct rnd_layout *layout,
                        void (*meanwhile)(void), char out_error[RND_ERROR_SIZE])
{
    struct numbers numbers = {{number_rows}, layout, meanwhile, 0};
    const bool ok = rnd_image_write_apart(program, fd, layout, &numbers.source, out_error, RND_ERROR_SIZE);
    if (ok) assert_int_equal(numbers.rows, layout->height);
    assert_true(ok || (*out_error && !strchr(out_error, '\n')));
    return ok;
}

static int create(const char *path)
{
    const int fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    assert_true(fd >= 0);
    return fd;
}

static void assert_same_file(const char *a, const char *b)
{
    FILE *file[2] = {fopen(a, "rb"), fopen(b, "rb")};
    int byte;
    long count = 0;
    assert_true(file[0] && file[1]);
    do {
        byte = fgetc(file[0]);
        assert_int_equal(byte, fgetc(file[1]));
    } while (byte != EOF && ++count);
    assert_true(count > 0);
    fclose(file[0]);
    fclose(file[1]);
}

/* The file has the right content, and is the same, bit for bit, as one written by this process. */
static void written(void **state)
{
    (void)state;
    struct rnd_layout layouts[] = {wide, wide, wide, wide};
    struct rnd_pixels pixels;
    char error[RND_ERROR_SIZE] = "", name[32];
    layouts[1].width = 1, layouts[1].height = 300;
    layouts[2].channels = 3;
    strcpy(layouts[2].format, "hdr");
    layouts[3].channels = 3;
    strcpy(layouts[3].format, "png");
    for (int c = 0; c < 3; c++) layouts[2].channel[c].type = RND_FLOAT, layouts[3].channel[c].type = RND_BYTE;
    for (size_t k = 0; k < sizeof layouts / sizeof *layouts; k++) {
        const struct rnd_layout *layout = &layouts[k];
        struct numbers numbers = {{number_rows}, layout, NULL, 0};
        snprintf(name, sizeof name, "apart.%s", layout->format);
        const char *apart = files_path(name), *here = files_path("here");
        const int fd = create(apart);
        FILE *file = fopen(here, "wb");
        assert_non_null(file);
        if (!write_apart(files_image_program(), fd, layout, NULL, error)) fail_msg("%s", error);
        if (!rnd_pixels_write(file, layout, &numbers.source, error, sizeof error)) fail_msg("%s", error);
        assert_int_equal(fclose(file), 0);
        close(fd);
        assert_same_file(apart, here);
        if (strcmp(layout->format, "exr") != 0) continue;
        if (!rnd_pixels_read(&(struct rnd_pixels_file){.path = apart, .use = RND_PIXELS_DATA}, &pixels, error,
                             sizeof error))
            fail_msg("%s", error);
        assert_int_equal(pixels.width, layout->width);
        assert_int_equal(pixels.height, layout->height);
        assert_int_equal(pixels.channels, 5);
        assert_string_equal(pixels.channel_names[0], "R");
        for (int c = 0; c < 5; c++) {
            int channel = 0;
            while (strcmp(pixels.channel_names[c], layout->channel[channel].name) != 0) channel++;
            const size_t last = (size_t)layout->width * (size_t)layout->height - 1;
            assert_float_equal(pixels.floats[5 * last + (size_t)c],
                               at(layout->width - 1, layout->height - 1, channel), 3e-4);
        }
        rnd_pixels_finish(&pixels);
    }
}

/* A picture that cannot be written gives one line that says why, and the next picture is written. */
static void refused(void **state)
{
    (void)state;
    struct rnd_layout odd = wide;
    char error[RND_ERROR_SIZE] = "";
    const char *path = files_path("refused.exr");
    int fd = create(path);
    strcpy(odd.format, "xyz");
    assert_false(write_apart(files_image_program(), fd, &odd, NULL, error));
    close(fd);
    const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
    assert_true(full >= 0);
    assert_false(write_apart(files_image_program(), full, &wide, NULL, error));
    assert_string_equal(error, "No space left on device");
    close(full);
    fd = create(path);
    if (!write_apart(files_image_program(), fd, &wide, NULL, error)) fail_msg("%s", error);
    close(fd);

    /* A limit on this program also applies to the writer, and does not count as a crash. */
    struct rlimit before, small;
    struct rnd_image_program *program = rnd_image_program_create();
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 20000;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    fd = create(path);
    assert_false(write_apart(program, fd, &wide, NULL, error));
    assert_string_equal(error, "File too large");
    close(fd);
    rnd_image_program_destroy(program);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
}

/* --- while a picture is written --- */

/* The parent of a process and its state (proc(5)). Returns false if there is no such process. */
static bool look(const char *pid, pid_t *out_parent, char *out_state)
{
    char path[64], line[512] = "";
    long parent = 0;
    snprintf(path, sizeof path, "/proc/%.20s/stat", pid);
    FILE *file = fopen(path, "r");
    if (!file) return false;
    const char *rest = fgets(line, sizeof line, file) ? strrchr(line, ')') : NULL;
    const bool ok = rest && sscanf(rest + 1, " %c %ld", out_state, &parent) == 2;
    fclose(file);
    *out_parent = (pid_t)parent;
    return ok;
}

/* The only process started by pid that has not ended. */
static pid_t child_of(pid_t pid)
{
    DIR *processes = opendir("/proc");
    struct dirent *entry;
    pid_t found = 0, parent;
    char status;
    assert_non_null(processes);
    while ((entry = readdir(processes))) {
        if (!look(entry->d_name, &parent, &status) || parent != pid || status == 'Z') continue;
        assert_int_equal(found, 0);
        found = (pid_t)atol(entry->d_name);
    }
    closedir(processes);
    assert_true(found > 0);
    return found;
}

static void stop_politely(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    const pid_t program = child_of(getpid()), writer = child_of(program);
    assert_int_not_equal(getpgid(program), getpgid(0));
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kill(program, numbers[i]), 0);
        assert_int_equal(kill(writer, numbers[i]), 0);
    }
}

static void kill_writer(void)
{
    assert_int_equal(kill(child_of(child_of(getpid())), SIGKILL), 0);
}

static int programs_killed;

static void kill_program(void)
{
    programs_killed++;
    assert_int_equal(kill(child_of(getpid()), SIGKILL), 0);
}

static void kill_one_program(void)
{
    if (programs_killed == 0) kill_program();
}

static void ended(void **state)
{
    (void)state;
    static const struct {
        void (*meanwhile)(void);
        const char *error;              /* NULL: the picture is written nevertheless */
    } cases[] = {{stop_politely, NULL}, /* a signal that stops a daemon must not stop its writer */
                 {kill_writer, "the writer crashed (signal 9)"},
                 {kill_one_program, NULL}, /* another one is started */
                 {kill_program, "the writer has gone"}};
    const char *path = files_path("meanwhile.exr"), *here = files_path("here.exr");
    char error[RND_ERROR_SIZE] = "";
    rnd_image_program_destroy(files_image_program_started); /* from here on there is one program at a time */
    files_image_program_started = NULL;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct rnd_image_program *program = rnd_image_program_create();
        assert_non_null(program);
        programs_killed = 0;
        int fd = create(path);
        const bool ok = write_apart(program, fd, &wide, cases[k].meanwhile, error);
        close(fd);
        print_message("%zu: %s\n", k, ok ? "written" : error);
        assert_int_equal(ok, !cases[k].error);
        if (!ok) assert_string_equal(error, cases[k].error);
        fd = ok ? create(here) : create(path);
        if (!write_apart(program, fd, &wide, NULL, error)) fail_msg("%s", error);
        close(fd);
        if (ok) assert_same_file(path, here);
        rnd_image_program_destroy(program);
    }
    assert_int_equal(programs_killed, 2);
}

/* A render can be saved after its first scene was destroyed, whether the caller or the scene started the
 * program. */
static void outlived(void **state)
{
    (void)state;
    const struct rnd_render_options options = {
        .width = 256, .height = 128, .threads = 1, .distribution = rnd_distribution_at(0)};
    struct rnd_scene_options files = {.path = files_room("room.obj")};
    char error[RND_ERROR_SIZE] = "";
    int width, height;
    for (int own = 0; own < 2; own++) {
        struct rnd_image_program *program = own ? NULL : rnd_image_program_create();
        files.image_program = program;
        struct rnd_scene *scene = rnd_scene_load(&files, error), *next = rnd_scene_load(&files, error);
        assert_true(scene && next);
        struct rnd_render *render = rnd_render_create(scene, &options, error);
        assert_non_null(render);
        rnd_render_restart(render, next, rnd_scene_info(next)->camera);
        rnd_scene_destroy(scene);
        rnd_image_program_destroy(program);
        const char *path = files_path("outlived.exr");
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        if (!rnd_render_save(render, file, path, &(struct rnd_exposure){0}, error)) fail_msg("%s", error);
        assert_int_equal(fclose(file), 0);
        rnd_render_destroy(render);
        rnd_scene_destroy(next);
        float *samples = rnd_image_read_channel(path, "samples", &width, &height, error);
        assert_non_null(samples);
        assert_int_equal(width, 256);
        free(samples);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(written), cmocka_unit_test(refused),
                                       cmocka_unit_test(ended), cmocka_unit_test(outlived)};
    return cmocka_run_group_tests_name("renderer_writer", tests, files_setup, files_teardown);
}
