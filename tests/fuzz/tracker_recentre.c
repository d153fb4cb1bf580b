/* Fuzzing of the file that keeps the rotation of recentring: any bytes are either a rotation, which is still
 * the same after it has been written and read again, or one line of error. See fuzz.h. */
#include "fuzz.h"

#include "tracker.h"

#include <math.h>
#include <sys/mman.h>
#include <unistd.h>

/* Make a file in memory and a name for it. */
static int memory(char name[64])
{
    int fd = memfd_create("recentre", 0);
    if (fd < 0) abort();
    snprintf(name, 64, "/proc/self/fd/%d", fd);
    return fd;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char name[64];
    static int fd = -1;
    float rotation[4] = {7, 7, 7, 7}, again[4];
    char error[TRK_ERROR_SIZE] = "";
    if (fd < 0) fd = memory(name);
    if (ftruncate(fd, 0) != 0 || pwrite(fd, data, size, 0) != (ssize_t)size) abort();
    if (!trk_recentre_load(name, rotation, error)) {
        if (!*error || strpbrk(error, "\r\n")) abort();
        for (int i = 0; i < 4; i++)
            if (rotation[i] != 7) abort();
        return 0;
    }
    double norm = 0;
    for (int i = 0; i < 4; i++) norm += (double)rotation[i] * (double)rotation[i];
    if (!(fabs(norm - 1) < 1e-2)) abort();
    FILE *out = fopen(name, "w");
    if (!out) abort();
    trk_recentre_print(rotation, out);
    if (fclose(out) != 0 || !trk_recentre_load(name, again, error)) abort();
    if (memcmp(again, rotation, sizeof again) != 0) abort();
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, 50000);
}

#endif
