/* clocks: the times of a log. Times never go back, and the clock must not stand still. */
#ifndef FOVEAD_TRACKER_LOG_CLOCKS_H
#define FOVEAD_TRACKER_LOG_CLOCKS_H

#include "log/reading.h"

/* The length of a tick in ns: the one from the options, else own_ns. */
double trk_time_unit(const struct trk_reading *reading, double own_ns);

/* A time may go back by this much and still count as equal to the time before it, because stamps are not
 * exact. */
#define TRK_MAX_STEP_BACK_NS UINT64_C(100000000)

/* A clock that counts from its first time and never goes back. A time that is a little earlier than the last
 * one counts as the last one, and reading->held counts it. A time further back is refused. */
struct trk_log_clock {
    bool started;
    int64_t first_ns;
    uint64_t last_ns;
};
bool trk_log_clock_count(struct trk_log_clock *clock, int64_t time_ns, struct trk_reading *reading,
                         uint64_t *out_ns, char out_error[TRK_ERROR_SIZE]);

/* Check that the times of the samples so far come from a running clock: they are not all the same, they do
 * not mostly repeat and then jump, and no spreadsheet has rounded them. If they fail the check, the log's
 * other clock replaces this one, and a note says so. False with a message if the other clock fails too. */
bool trk_check_clocks(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

#endif
