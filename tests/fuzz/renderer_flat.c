/* Fuzzing of what fovead-reader hands over: any bytes are either a scene whose parts are consistent, or
 * refused.
 *
 * As a test it spoils what the reader hands over for a small scene, from a fixed seed. See fuzz.h. */
#include "fuzz.h"
#include "scene_check.h"

#include "import/flat_put.h"
#include "import/flat_take.h"
#include "import/formats.h"

#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    char why[200] = "";
    void *bytes =
        aligned_alloc(16, size + 16 - size % 16); /* nearly exact: a sanitizer notices access beyond */
    if (!scene || !bytes) abort();
    memcpy(bytes, data, size);
    scene->flat = bytes;
    scene->flat_bytes = size;
    if (rnd_flat_take(scene, why, sizeof why)) {
        scene_check(scene);
        scene_check_files(&scene->info);
    } else if (!*why || strchr(why, '\n'))
        abort();
    scene->flat = NULL; /* it is not mapped */
    scene->mesh_count = 0;
    for (uint32_t i = 0; i < scene->texture_count; i++) scene->texture[i].file = NULL;
    rnd_scene_destroy(scene);
    free(bytes);
    return 0;
}

#ifndef LIBFUZZER

enum { ROOM = 1 << 16 };

/* What the reader hands over for a file. */
static size_t seed(const char *path, uint8_t out[ROOM])
{
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    char error[RND_ERROR_SIZE];
    const int fd = memfd_create("seed", MFD_CLOEXEC);
    if (!scene || fd < 0) abort();
    if (!rnd_import(scene, path, error)) exit((fprintf(stderr, "%s\n", error), 1));
    if (!rnd_flat_put(scene, fd)) abort();
    const ssize_t size = pread(fd, out, ROOM, 0);
    close(fd);
    rnd_scene_destroy(scene);
    return (size_t)size;
}

/* Replace a number of eight or four bytes. */
static void spoil_word(uint64_t *state, uint8_t *bytes, size_t size)
{
    static const uint64_t others[] = {0, 1, 2, 3, 16, 255, 65535, UINT32_MAX, UINT64_MAX, (uint64_t)1 << 62};
    const size_t length = fuzz_noise(state) % 2 ? 8 : 4, at = fuzz_noise(state) % (size / 4) * 4;
    uint64_t word = 0;
    if (at + length > size) return;
    memcpy(&word, bytes + at, length);
    word = fuzz_noise(state) % 2 ? others[fuzz_noise(state) % (sizeof others / sizeof *others)]
                                 : word + fuzz_noise(state) % 65 - 32;
    memcpy(bytes + at, &word, length);
}

int main(void)
{
    static uint8_t good[ROOM], input[ROOM];
    uint64_t state = 11;
    const size_t whole = seed(SEED, good);
    LLVMFuzzerTestOneInput(good, whole);
    for (size_t size = 0; size < whole; size += 61) LLVMFuzzerTestOneInput(good, size);
    for (int round = 0; round < 20000; round++) {
        size_t size = whole, head = fuzz_noise(&state) % 2 ? sizeof(struct rnd_flat_head) : whole;
        memcpy(input, good, whole);
        for (uint64_t hits = 1 + fuzz_noise(&state) % 3; hits > 0; hits--)
            if (fuzz_noise(&state) % 4)
                spoil_word(&state, input, head);
            else
                size = fuzz_spoil(&state, input, size, ROOM);
        LLVMFuzzerTestOneInput(input, size);
    }
    printf("20000 inputs from %zu bytes\n", whole);
    return 0;
}

#endif
