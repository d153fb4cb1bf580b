/* Fuzzing of --watch: what files are called that come and go in the folder of a scene, and what the scene's
 * own text says of them.
 *
 * An input is up to four names, one a line, an empty line, and the scene's text. Files of these names are
 * made in a folder that is really watched; a name that stands in the text is found. See fuzz.h. The source is
 * included, since what it has to be asked is nobody else's; what it calls to take an edit up is not reached.
 */
#include "fuzz.h"

#include "../../daemon/edits.c"

bool dmn_painter_moved(struct dmn_painter *painter, double out_eye[3])
{
    (void)painter, (void)out_eye;
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

/* Is it written in the text as a whole word, letter for letter? More is found than that, never less. */
static bool stands_in(const char *name, const uint8_t *text, size_t size)
{
    const size_t length = strlen(name);
    for (size_t at = 0; at + length <= size; at++) {
        if (memcmp(text + at, name, length) != 0) continue;
        if ((at == 0 || !goes_on(text[at - 1])) && (at + length == size || !goes_on(text[at + length])))
            return true;
    }
    return false;
}

/* However it is written: in another letter case, or as a URI. */
static void check_name(const char *name)
{
    char text[3 * NAME_SIZE + 4];
    int length = sprintf(text, "\"");
    for (const char *c = name; *c; c++)
        length += sprintf(text + length, "%c", islower((unsigned char)*c) ? toupper((unsigned char)*c) : *c);
    length += sprintf(text + length, "\"");
    if (!finds(text, (size_t)length, true, false, name)) abort();
    length = sprintf(text, "\"");
    for (const char *c = name; *c; c++) length += sprintf(text + length, "%%%02x", (unsigned char)*c);
    length += sprintf(text + length, "\"");
    if (!finds(text, (size_t)length, true, true, name)) abort();
    /* As the end of a longer one it is not. */
    length = sprintf(text, "x%s", name);
    if (finds(text, (size_t)length, true, false, name) && !strchr(name + 1, *name) &&
        tolower('x') != tolower((unsigned char)*name) && *name != '%')
        abort();
}

static bool make(const char *name, char path[512])
{
    if (snprintf(path, 512, "%s/%s", folder, name) >= 512 || strchr(name, '/') || !strcmp(path, scene))
        return false;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
    if (fd < 0) return false; /* ".", "..", too long, there already */
    if (write(fd, name, strlen(name)) < 0) abort();
    close(fd);
    return true;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[MOST_FILES][NAME_SIZE + 8], path[MOST_FILES][512];
    const uint8_t *end = data + size, *text = end;
    bool written = false;
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
    put(scene, text, (size_t)(end - text));
    forget();
    for (int i = 0; i < count; i++) {
        if (!make(name[i], path[i])) abort();
        written |= stands_in(name[i], text, (size_t)(end - text));
    }
    read_events(edits);
    if (edits->dirty || edits->count != count) abort();
    for (int i = 0; i < count; i++) check_name(edits->changed[i]);
    if (count && !concerns_scene(edits) && written) abort();
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
