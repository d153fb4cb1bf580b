/* Fuzzing of the glTF reader: any bytes either are a scene whose parts hold together, or one line of error.
 *
 * As it is built here it is a test of its own that starts from the small files in corpus/gltf and spoils
 * their bytes (fuzz.h) and their numbers. With libFuzzer (Embree and OpenImageIO come with the library):
 *   clang -g -O1 -fsanitize=fuzzer,address,undefined -DLIBFUZZER -D_GNU_SOURCE -Irenderer -Itests/fuzz \
 *       tests/fuzz/renderer_gltf.c $BUILD/renderer/librenderer.a ...
 */
#include "fuzz.h"

#include "scene/scene.h"

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

static void check_map(const struct rnd_scene *scene, const struct rnd_map *map)
{
    if (map->texture >= (int)scene->texture_count || map->uv_set > 1) abort();
}

static void check(const struct rnd_scene *scene)
{
    if (scene->mesh_count == 0 || scene->info.triangles == 0) abort();
    for (uint32_t m = 0; m < scene->mesh_count; m++) {
        const struct rnd_mesh *mesh = &scene->mesh[m];
        if (mesh->material >= scene->material_count) abort();
        for (size_t i = 0; i < 3 * (size_t)mesh->vertices; i++)
            if (!isfinite(mesh->position[i]) || (mesh->normal && !isfinite(mesh->normal[i]))) abort();
        for (size_t i = 0; mesh->colour && i < 4 * (size_t)mesh->vertices; i++)
            if (!(mesh->colour[i] >= 0.0f && mesh->colour[i] <= 1.0f)) abort();
        for (uint32_t t = 0; t < mesh->triangles; t++)
            for (int k = 0; k < 3; k++)
                if (mesh->index[t][k] >= mesh->vertices) abort();
    }
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (!scene->mesh[scene->instance[i].mesh].instanced) abort();
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const struct rnd_material *m = &scene->material[i];
        if (!isfinite(m->roughness + m->metallic + m->ior + m->base.x + m->emission.x + m->absorption.x))
            abort();
        for (int use = 0; use < RND_MAPS; use++) check_map(scene, &m->map[use]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    char error[RND_ERROR_SIZE] = "";
    if (!*file[0]) make_files();
    FILE *out = fopen(file[0], "wb");
    if (!out || !scene || fwrite(data, 1, size, out) != size || fclose(out) != 0) abort();
    if (rnd_import(scene, file[0], error))
        check(scene);
    else if (!*error || strchr(error, '\n'))
        abort();
    rnd_scene_destroy(scene);
    return 0;
}

#ifndef LIBFUZZER

#include <ctype.h>

/* Put something else in the place of a number. */
static size_t spoil_number(uint64_t *state, char *text, size_t size, size_t room)
{
    static const char *const others[] = {
        "0",   "1",     "2",     "3",    "-1", "7",  "255",    "65536", "4294967295", "4294967296", "1e300",
        "0.5", "1e-40", "\"x\"", "null", "[]", "{}", "999999", "5121",  "5123",       "5126"};
    size_t at = fuzz_noise(state) % size, end;
    while (at < size && !isdigit((unsigned char)text[at])) at++;
    while (at > 0 && (isalnum((unsigned char)text[at - 1]) || strchr("-+.", text[at - 1]))) at--;
    for (end = at; end < size && (isalnum((unsigned char)text[end]) || strchr("-+.", text[end]));) end++;
    const char *other = others[fuzz_noise(state) % (sizeof others / sizeof *others)];
    const size_t length = strlen(other);
    if (at >= size || size - (end - at) + length > room) return size;
    memmove(text + at + length, text + end, size - end);
    memcpy(text + at, other, length);
    return size - (end - at) + length;
}

/* Every file of the folder with up to six numbers of its JSON changed. */
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
                size = spoil_number(&state, input, size, sizeof input);
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
