/* Fuzzing of our own reader of OBJ and MTL files: any text gives materials with usable numbers.
 *
 * The text before a line of three dashes is the OBJ file, and the rest is its x.mtl. Without such a line all
 * of it is x.mtl. See fuzz.h. */
#include "fuzz.h"

#include "import/mtl_file.h"
#include "scene/scene.h"

#include <math.h>
#include <unistd.h>

static char folder[64], obj[80], mtl[80]; /* folder ends with a slash */

static void tidy(void)
{
    unlink(obj);
    unlink(mtl);
    rmdir(folder);
}

static void make_folder(void)
{
    strcpy(folder, access("/dev/shm", W_OK) ? "/tmp/fuzz_mtl.XXXXXX" : "/dev/shm/fuzz_mtl.XXXXXX");
    if (!mkdtemp(folder)) abort();
    strcat(folder, "/");
    snprintf(obj, sizeof obj, "%.60sx.obj", folder);
    snprintf(mtl, sizeof mtl, "%.60sx.mtl", folder);
    atexit(tidy);
}

static void put(const char *path, const void *bytes, size_t count)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, count, file) != count || fclose(file) != 0) abort();
}

static void check(const struct rnd_mtl_file *file)
{
    for (int i = 0; i < file->count; i++) {
        const struct rnd_mtl_material *m = &file->material[i];
        if (m->library < 0 || m->library >= file->libraries || !m->name) abort();
        /* Finds the last material of this name, which may be another one. */
        if (!rnd_mtl_file_find(file, m->name)) abort();
        if (!isfinite(m->bump)) abort();
        for (int k = 0; k < RND_MTL_MAPS; k++)
            for (int c = 0; c < 2; c++)
                if (!isfinite(m->scale[k][c]) || !isfinite(m->offset[k][c])) abort();
    }
    for (int i = 0; i < file->libraries; i++) {
        const size_t length = strnlen(file->directory[i], RND_PATH_SIZE);
        if (length == RND_PATH_SIZE || (length && file->directory[i][length - 1] != '/')) abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char plain[] = "mtllib x.mtl\n";
    const uint8_t *dashes = size ? memmem(data, size, "---\n", 4) : NULL;
    struct rnd_mtl_file file;
    static struct rnd_scene scene;
    if (!*folder) make_folder();
    if (dashes) {
        put(obj, data, (size_t)(dashes - data));
        put(mtl, dashes + 4, size - 4 - (size_t)(dashes - data));
    } else {
        put(obj, plain, strlen(plain));
        put(mtl, data, size);
    }
    if (rnd_mtl_file_read(&file, obj, folder, &scene)) check(&file);
    rnd_mtl_file_finish(&file);
    if (!rnd_files_are_whole(scene.files.text, scene.files.size)) abort();
    rnd_files_finish(&scene.files);
    free(scene.warnings.text);
    scene.warnings = (struct rnd_warnings){0};
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, 20000);
}

#endif
