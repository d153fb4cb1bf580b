/* Fuzzing of the glTF reader: any bytes are either a scene whose parts are consistent, or one line of error.
 *
 * As a test it starts from the small files in corpus/gltf and spoils their bytes and their numbers. See
 * fuzz.h. */
#include "fuzz.h"
#include "scene_check.h"

#include "import/formats.h"

#include <unistd.h>

static char file[2][64];

static void tidy(void)
{
    for (int i = 0; i < 2; i++) unlink(file[i]);
    *strrchr(file[0], '/') = 0;
    rmdir(file[0]);
}

static void make_files(void)
{
    char folder[32] = "/tmp/fuzz_gltf.XXXXXX";
    if (!mkdtemp(folder)) abort();
    for (int i = 0; i < 2; i++) snprintf(file[i], sizeof file[i], "%s/x.%s", folder, i ? "bin" : "gltf");
    FILE *buffer = fopen(file[1], "wb");
    if (!buffer) abort();
    for (int i = 0; i < 1000; i++) fputc(i % 7 ? i : 0, buffer);
    fclose(buffer);
    atexit(tidy);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    char error[RND_ERROR_SIZE] = "";
    if (!*file[0]) make_files();
    FILE *out = fopen(file[0], "wb");
    if (!out || !scene || fwrite(data, 1, size, out) != size || fclose(out) != 0) abort();
    if (rnd_import(scene, file[0], error))
        scene_check(scene);
    else if (!*error || strchr(error, '\n'))
        abort();
    rnd_scene_destroy(scene);
    return 0;
}

#ifndef LIBFUZZER

/* Run every file of the folder with up to six numbers of its JSON changed. */
static void spoil_numbers(const char *folder, int rounds)
{
    static char seed[8192], input[8192 + 1000];
    uint64_t state = 1;
    struct dirent **entries;
    const int found = scandir(folder, &entries, NULL, alphasort);
    for (int i = 0; i < found; free(entries[i++])) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        FILE *from = entries[i]->d_name[0] == '.' ? NULL : fopen(path, "rb");
        if (!from) continue;
        const size_t whole = fread(seed, 1, sizeof seed, from);
        fclose(from);
        for (int round = 0; round < rounds; round++) {
            size_t size = whole;
            memcpy(input, seed, whole);
            for (uint64_t hits = 1 + fuzz_noise(&state) % 6; hits > 0; hits--)
                size = fuzz_spoil_number(&state, input, size, sizeof input);
            LLVMFuzzerTestOneInput((const uint8_t *)input, size);
        }
    }
    if (found >= 0) free(entries);
}

int main(void)
{
    spoil_numbers(CORPUS, 1500);
    return fuzz_run_corpus(CORPUS, 4000);
}

#endif
