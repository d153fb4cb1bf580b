/* reopen: open a gaze source, wait for the first gaze, and close it, several times in one process.
 *
 *   reopen SPEC TIMES
 *
 * Prints a line and exits with 1 if a source cannot be opened, breaks or ends. */
#include "tracker.h"

#include <stdio.h>
#include <stdlib.h>

int main(int count, char **arguments)
{
    if (count != 3) return 2;
    struct trk_source_options options = {.spec = arguments[1], .speed = 1};
    for (int time = 1; time <= atoi(arguments[2]); time++) {
        char error[TRK_ERROR_SIZE] = "it ended";
        struct trk_sample sample = {0};
        enum trk_result result = TRK_TIMEOUT;
        struct trk_source *source = trk_open(&options, error);
        while (source && !(sample.valid & TRK_DIRECTION) && (result == TRK_SAMPLE || result == TRK_TIMEOUT))
            result = trk_read(source, UINT64_MAX, &sample, error);
        trk_close(source);
        if (result != TRK_SAMPLE) {
            printf("FAIL: time %d: %s\n", time, error);
            return 1;
        }
    }
    printf("opened and closed %s times\n", arguments[2]);
    return 0;
}
