/* Writing a gaze log to a path. */
#ifndef FOVEAD_TESTS_TRACKER_WRITE_H
#define FOVEAD_TESTS_TRACKER_WRITE_H

#include "tracker.h"

#include <stdio.h>

static inline bool written(const struct trk_log *log, const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) return false;
    trk_log_print(log, file);
    bool ok = !ferror(file);
    return fclose(file) == 0 && ok;
}

#endif
