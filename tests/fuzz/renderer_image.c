/* Fuzzing of pictures: any bytes are either a whole picture or one line of error.
 *
 * The first byte chooses the name of the file and what its pixels are used for. The rest is the file. See
 * fuzz.h. Memory is limited to what small pictures need, as in a process that reads the pictures of a scene,
 * so that a wrong size is refused. */
#include "fuzz.h"

#include "import/image_io.h"

#include "../sanitized.h"

#include <math.h>
#include <sys/resource.h>

enum { ROOM = 512 << 20 }; /* bytes */

/* With sanitizers the address space cannot be limited, because they reserve all of it; allocations that are
 * too large return NULL instead. Leaks are not checked: when a picture ends early, libraries leave by
 * longjmp() and lose what they have allocated (OpenImageIO 2.4.7, libpng). */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "detect_leaks=0:allocator_may_return_null=1:quarantine_size_mb=1";
}

static void limit(void)
{
    struct rlimit addresses = {ROOM, RLIM_INFINITY};
    long pages = 0;
    FILE *statm = fopen("/proc/self/statm", "r");
    if (SANITIZED || !statm || fscanf(statm, "%ld", &pages) != 1) abort();
    fclose(statm);
    addresses.rlim_cur += (rlim_t)pages * 4096;
    if (setrlimit(RLIMIT_AS, &addresses) != 0) abort();
}

static void check(const struct rnd_pixels *pixels, bool want_bytes)
{
    const size_t count = (size_t)pixels->width * (size_t)pixels->height * (size_t)pixels->channels;
    volatile double sum = 0;
    if (pixels->width < 1 || pixels->height < 1 || pixels->channels < 1 ||
        pixels->channels > RND_MAX_CHANNELS)
        abort();
    if (!pixels->bytes == !pixels->floats || (pixels->bytes && !want_bytes)) abort();
    for (size_t i = 0; i < count; i++)
        sum += pixels->bytes ? (double)pixels->bytes[i] : (double)pixels->floats[i];
    for (int c = 0; c < pixels->channels; c++)
        if (strnlen(pixels->channel_names[c], sizeof pixels->channel_names[c]) ==
            sizeof pixels->channel_names[c])
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[] = {"x.png", "x.jpg", "x.exr", "x.hdr", "x.tga", "x.bmp", "x.tif", "x"};
    static bool limited;
    struct rnd_pixels pixels;
    char error[256] = "";
    if (size < 2) return 0;
    if (!limited && !SANITIZED) limit();
    limited = true;
    const enum rnd_pixels_use use = (enum rnd_pixels_use)(data[0] >> 3 & 3);
    const bool want_bytes = data[0] & 32;
    if (use > RND_PIXELS_COLOUR) return 0;
    const struct rnd_pixels_file file = {.path = names[data[0] & 7],
                                         .memory = data + 1,
                                         .count = size - 1,
                                         .use = use,
                                         .want_bytes = want_bytes};
    if (rnd_pixels_read(&file, &pixels, error, sizeof error))
        check(&pixels, want_bytes);
    else if (!*error || strpbrk(error, "\r\n") || pixels.bytes || pixels.floats)
        abort();
    rnd_pixels_finish(&pixels);
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, SANITIZED ? 300 : 20000);
}

#endif
