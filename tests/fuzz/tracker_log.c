/* Fuzzing of every log reader: any bytes are either a log whose samples keep the promises of trk_log_read(),
 * or refused with one line.
 *
 * An input that begins with '{' and contains an empty line is a BIDS log: first the sidecar, then the table.
 * Any other input is a file. See fuzz.h. To fuzz one format, give libFuzzer a corpus of its logs only. */
#include "fuzz.h"

#include "../sanitized.h"

#include "log/own.h"
#include "tracker.h"

#include <fcntl.h>
#include <math.h>
#include <sys/mman.h>
#include <unistd.h>

static void write_all(int fd, const uint8_t *data, size_t size)
{
    if (fd < 0 || ftruncate(fd, 0) != 0 || pwrite(fd, data, size, 0) != (ssize_t)size) abort();
}

static char dir[64], table[96], sidecar[96];

static void tidy(void)
{
    unlink(table);
    unlink(sidecar);
    rmdir(dir);
}

/* Use a folder in memory if there is one, because disks are slow. */
static void make_dir(void)
{
    strcpy(dir, "/dev/shm/fuzz_log.XXXXXX");
    if (!mkdtemp(dir)) {
        strcpy(dir, "/tmp/fuzz_log.XXXXXX");
        if (!mkdtemp(dir)) abort();
    }
    snprintf(table, sizeof table, "%s/x.tsv", dir);
    snprintf(sidecar, sizeof sidecar, "%s/x.json", dir);
    atexit(tidy);
}

/* Write the input to a file: in memory, or, with its sidecar, in the folder. Returns the path. */
static const char *place(const uint8_t *data, size_t size)
{
    static char memory[64];
    static int memory_fd = -1, table_fd, sidecar_fd;
    const uint8_t *empty = size && data[0] == '{' ? memmem(data, size, "\n\n", 2) : NULL;
    if (memory_fd < 0) {
        memory_fd = memfd_create("log", 0);
        snprintf(memory, sizeof memory, "/proc/self/fd/%d", memory_fd);
        make_dir();
        table_fd = open(table, O_WRONLY | O_CREAT, 0600);
        sidecar_fd = open(sidecar, O_WRONLY | O_CREAT, 0600);
    }
    if (!empty) {
        write_all(memory_fd, data, size);
        return memory;
    }
    write_all(sidecar_fd, data, (size_t)(empty - data));
    write_all(table_fd, empty + 2, size - (size_t)(empty + 2 - data));
    return table;
}

static void check_log(const struct trk_log *log)
{
    if (!log->format || !*log->format || log->count == 0) abort();
    if (strlen(log->assumed) >= TRK_ASSUMED_SIZE || strpbrk(log->assumed, "\r\n")) abort();
    struct trk_sample samples[2];
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample *sample = &samples[i % 2], *last = &samples[!(i % 2)];
        trk_log_sample(log, i, sample);
        if (trk_log_time(log, i) != sample->device_ns || (sample->valid & ~trk_log_seen(log))) abort();
        if (!trk_own_accepts(sample)) abort(); /* directions are finite and of unit length */
        for (int eye = 0; eye < 2; eye++)
            if ((sample->valid & TRK_LEFT_OPENNESS << 4 * eye) &&
                !(sample->eye[eye].openness >= 0 && sample->eye[eye].openness <= 1) &&
                strcmp(log->format, "fovead") != 0)
                abort();
        if (i == 0) continue;
        if (sample->device_ns < last->device_ns || sample->arrival_ns < last->arrival_ns ||
            sample->sequence <= last->sequence)
            abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    if (trk_log_read(place(data, size), &log, error))
        check_log(&log);
    else if (!*error || strpbrk(error, "\r\n") || log.samples || log.count || log.format)
        abort();
    trk_log_finish(&log);
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, SANITIZED ? 20000 : 40000);
}

#endif
