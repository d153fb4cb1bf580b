/* clocks: the times of a log. They never go back, and they must be those of a clock that runs. */
#ifndef FOVEAD_TRACKER_LOG_CLOCKS_H
#define FOVEAD_TRACKER_LOG_CLOCKS_H

#include "log/reading.h"

/* The ns of a tick: that of the options, else own_ns. */
double trk_time_unit(const struct trk_reading *reading, double own_ns);

/* How far a time may go back and still count as the time before it: stamps are not exact. */
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

/* Check that the times of the samples so far are those of a clock: not all the same, not the same for most
 * rows and then far apart, not rounded by a spreadsheet. Otherwise the log's other clock is used, and that is
 * noted. False with a message if the other clock does not run either. */
bool trk_check_clocks(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

#endif
