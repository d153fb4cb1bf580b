/* Fuzzing of --watch: the names of files that change in a scene's folder, and the files that the scene names.
 *
 * An input is up to four names, one per line, an empty line, and the paths that the scene names, one per
 * line. Files with the four names are made in a folder that is watched; those that the scene names must count
 * as changes. See fuzz.h. This file includes edits.c because it calls its static functions. The functions
 * that take up an edit are not tested. */
#include "fuzz.h"

#include <fcntl.h>

#include "../../daemon/edits.c"

bool dmn_painter_moved(struct dmn_painter *painter, double out_camera[3])
{
    (void)painter, (void)out_camera;
    abort();
}

struct rnd_scene *dmn_painter_replace(struct dmn_painter *painter, struct rnd_scene *scene)
{
    (void)painter, (void)scene;
    abort();
}

void dmn_report_scene(const struct rnd_scene_info *info, const char *path, char *out_line, size_t size)
{
    (void)info, (void)path, (void)out_line, (void)size;
    abort();
}

void dmn_report_left_out(const struct rnd_scene_info *info, const char *path)
{
    (void)info, (void)path;
    abort();
}

enum { MOST_FILES = 4 };

static char folder[64], scene[80];
static struct dmn_edits *edits;

static void tidy(void)
{
    dmn_edits_destroy(edits);
    unlink(scene);
    rmdir(folder);
}

static void put(const char *path, const void *bytes, size_t count)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, count, file) != count || fclose(file) != 0) abort();
}

static void begin(void)
{
    static struct rnd_scene_options options;
    char error[RND_ERROR_SIZE];
    strcpy(folder, access("/dev/shm", W_OK) ? "/tmp/fuzz_edits.XXXXXX" : "/dev/shm/fuzz_edits.XXXXXX");
    if (!mkdtemp(folder)) abort();
    snprintf(scene, sizeof scene, "%s/scene.gltf", folder);
    put(scene, "", 0);
    options.path = scene;
    edits = dmn_edits_create(&options, error);
    if (!edits) abort();
    atexit(tidy);
}

static void forget(void)
{
    read_events(edits);
    edits->dirty = false;
    edits->count = 0;
}

/* Does one of the paths end in this name, in upper or lower case? */
static bool is_named(const char *name, const char *paths, size_t size)
{
    const size_t length = strlen(name);
    for (size_t at = 0; at < size; at += strlen(paths + at) + 1) {
        const size_t whole = strlen(paths + at);
        if (whole < length || strcasecmp(paths + at + whole - length, name) != 0) continue;
        if (whole == length || paths[at + whole - length - 1] == '/') return true;
    }
    return false;
}

static bool make(const char *name, char path[512])
{
    if (snprintf(path, 512, "%s/%s", folder, name) >= 512 || strchr(name, '/') || !strcmp(path, scene))
        return false;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
    if (fd < 0) return false; /* it is ".", "..", too long, or exists already */
    if (write(fd, name, strlen(name)) < 0) abort();
    close(fd);
    return true;
}

/* Take the lines as the paths that the scene names. */
static void take_paths(const uint8_t *text, size_t size)
{
    char paths[4096];
    size_t used = 0;
    for (size_t i = 0; i < size && used < sizeof paths - 1; i++) {
        const char byte = (char)(text[i] == '\n' ? 0 : text[i]);
        if (byte || (used > 0 && paths[used - 1])) paths[used++] = byte;
    }
    if (used > 0 && paths[used - 1]) paths[used++] = 0;
    const struct rnd_scene_info info = {.files = paths, .files_bytes = used};
    if (!keep_files(edits, &info)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[MOST_FILES][NAME_SIZE + 8], path[MOST_FILES][512];
    const uint8_t *end = data + size, *text = end;
    bool named = false;
    int count = 0;
    if (!edits) begin();
    for (const uint8_t *line = data; count < MOST_FILES && line < end;) {
        const uint8_t *stop = memchr(line, '\n', (size_t)(end - line));
        size_t length = (size_t)((stop ? stop : end) - line);
        text = stop ? stop + 1 : end;
        if (length == 0) break;
        if (length < sizeof name[0] && !memchr(line, 0, length)) {
            memcpy(name[count], line, length);
            name[count][length] = 0;
            if (make(name[count], path[count])) count++;
        }
        line = text;
    }
    for (int i = 0; i < count; i++) unlink(path[i]);
    take_paths(text, (size_t)(end - text));
    forget();
    for (int i = 0; i < count; i++) {
        if (!make(name[i], path[i])) abort();
        named |= is_named(name[i], edits->files, edits->files_bytes);
    }
    read_events(edits);
    if (edits->dirty || edits->count != count) abort();
    if (concerns_scene(edits) != named) abort();
    for (int i = 0; i < count; i++) unlink(path[i]);
    forget();
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, 10000);
}

#endif
