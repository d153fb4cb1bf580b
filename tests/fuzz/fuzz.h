/* What the fuzz targets share. When they are built as tests, each does a limited number of random changes to
 * valid inputs, from a fixed seed. With -DLIBFUZZER this is left out, and libFuzzer runs them for as long as
 * it may:
 *   CC=clang CXX=clang++ cmake -S . -B build/fuzz -G Ninja -DFUZZ=ON -DSANITIZE=address,undefined
 *   cmake --build build/fuzz --target fuzz
 *   build/fuzz/fuzz_protocol_picture -max_len=4096 FOUND tests/fuzz/corpus/picture
 * FOUND is a folder for new inputs. */
#ifndef FOVEAD_TEST_FUZZ_H
#define FOVEAD_TEST_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#ifndef LIBFUZZER

#include <ctype.h>
#include <dirent.h>

struct fuzz_seed {
    const uint8_t *bytes;
    size_t size;
};

static inline uint64_t fuzz_noise(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 33;
}

/* Spoil an input of size bytes in one of a few ways. Returns the new size. */
static inline size_t fuzz_spoil(uint64_t *state, uint8_t *input, size_t size, size_t room)
{
    size_t at = fuzz_noise(state) % size, to = fuzz_noise(state) % size;
    switch (fuzz_noise(state) % 6) {
    case 0:
        input[at] ^= (uint8_t)(1 << fuzz_noise(state) % 8);
        return size;
    case 1:
        input[at] = (uint8_t)fuzz_noise(state);
        return size;
    case 2:
        return at + 1;
    case 3:
        memmove(input + to, input + at, size - (at > to ? at : to));
        return size;
    case 4:
        input[at] = 0xff;
        return size;
    default:
        if (size == room) return size;
        memmove(input + at + 1, input + at, size - at);
        return size + 1;
    }
}

/* Replace a number in the text by something else. */
static inline size_t fuzz_spoil_number(uint64_t *state, char *text, size_t size, size_t room)
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

/* Run `rounds` inputs, each a seed with up to 7 changes, in a heap block of its exact size. */
static inline int fuzz_run(const struct fuzz_seed *seeds, size_t count, int rounds)
{
    static uint8_t input[8192];
    uint64_t state = 360;
    for (int round = 0; round < rounds; round++) {
        const struct fuzz_seed *seed = &seeds[fuzz_noise(&state) % count];
        size_t size = seed->size;
        memcpy(input, seed->bytes, size);
        for (uint64_t hits = fuzz_noise(&state) % 8; hits > 0; hits--)
            size = fuzz_spoil(&state, input, size, sizeof input);
        uint8_t *exact = malloc(size);
        if (!exact) abort();
        memcpy(exact, input, size);
        LLVMFuzzerTestOneInput(exact, size);
        free(exact);
    }
    printf("%d inputs from %zu seeds\n", rounds, count);
    return 0;
}

/* The same with every file of a folder as a seed. Each is first run unchanged. */
static inline int fuzz_run_corpus(const char *folder, int rounds)
{
    enum { MOST = 256, ROOM = 4096 };
    static uint8_t bytes[MOST][ROOM];
    static struct fuzz_seed seeds[MOST];
    struct dirent **entries;
    const int found = scandir(folder, &entries, NULL, alphasort);
    size_t count = 0;
    for (int i = 0; i < found; free(entries[i++])) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        FILE *file = entries[i]->d_name[0] == '.' || count == MOST ? NULL : fopen(path, "rb");
        if (!file) continue;
        seeds[count] = (struct fuzz_seed){bytes[count], fread(bytes[count], 1, ROOM, file)};
        if (seeds[count].size > 0) count++;
        fclose(file);
    }
    if (found >= 0) free(entries);
    if (count == 0) {
        fprintf(stderr, "%s: holds no inputs\n", folder);
        return 1;
    }
    for (size_t i = 0; i < count; i++) LLVMFuzzerTestOneInput(seeds[i].bytes, seeds[i].size);
    return fuzz_run(seeds, count, rounds);
}

#endif
#endif
