/* until: when a render is done. */
#ifndef FOVEAD_DAEMON_UNTIL_H
#define FOVEAD_DAEMON_UNTIL_H

#include <stdbool.h>
#include <stdint.h>

enum dmn_until_kind {
    DMN_UNTIL_STOPPED,
    DMN_UNTIL_PATHS,
    DMN_UNTIL_SECONDS,
    DMN_UNTIL_CONVERGED,
    DMN_UNTIL_END
};

struct dmn_until {
    enum dmn_until_kind kind;
    double amount; /* paths per film pixel, or seconds of rendering */
};

struct dmn_progress {
    uint64_t paths, pixels;
    double seconds;
    uint32_t tiles, converged;
    bool gaze_ended;
};

/* "256spp", "30s", "converged" or "end". */
bool dmn_until_parse(const char *text, struct dmn_until *out_until);
/* How much of the render is done, 0 to 1; exactly 1 when it is done. */
double dmn_until_share(const struct dmn_until *until, const struct dmn_progress *progress);

#endif
