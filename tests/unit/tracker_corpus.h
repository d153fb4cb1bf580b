/* The small logs of every format, for tests: functions that read one into memory, and a folder of the test's
 * own to write changed ones into. */
#ifndef FOVEAD_TESTS_TRACKER_CORPUS_H
#define FOVEAD_TESTS_TRACKER_CORPUS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CORPUS FIXTURES "/../tests/fuzz/corpus/log/"

/* The test's folder, the log in it, and the sidecar of a BIDS log. */
static char dir[64], path[96], sidecar[96];

static inline int enter(void **state)
{
    (void)state;
    snprintf(dir, sizeof dir, "tracker_corpus.XXXXXX");
    if (!mkdtemp(dir)) return -1;
    snprintf(path, sizeof path, "%s/x.tsv.gz", dir);
    snprintf(sidecar, sizeof sidecar, "%s/x.json", dir);
    return 0;
}

static inline int leave(void **state)
{
    (void)state;
    unlink(path);
    unlink(sidecar);
    return rmdir(dir);
}

static inline void spill(const char *to, const char *bytes, size_t size)
{
    FILE *file = fopen(to, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Read a small log of the corpus into out_text and end it with a NUL. The file of a BIDS log holds the
 * sidecar, an empty line and the table: the sidecar is written beside path, and only the table is returned.
 * Returns the size, which is less than room. */
static inline size_t corpus(const char *file, char *out_text, size_t room)
{
    char from[512];
    snprintf(from, sizeof from, CORPUS "%s", file);
    FILE *in = fopen(from, "rb");
    if (!in) fail_msg("no %s", from);
    size_t size = fread(out_text, 1, room - 1, in);
    fclose(in);
    out_text[size] = '\0';
    char *table = strncmp(file, "bids", 4) == 0 ? strstr(out_text, "\n\n") : NULL;
    if (table) {
        spill(sidecar, out_text, (size_t)(table - out_text));
        size -= (size_t)(table + 2 - out_text);
        memmove(out_text, table + 2, size + 1);
    }
    return size;
}

#endif
