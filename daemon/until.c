/* When a render is done. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "until.h"

bool dmn_until_parse(const char *text, struct dmn_until *out_until)
{
    char *end;

    *out_until = (struct dmn_until){0};
    if (!strcmp(text, "converged")) {
        out_until->kind = DMN_UNTIL_CONVERGED;
        return true;
    }
    if (!strcmp(text, "end")) {
        out_until->kind = DMN_UNTIL_END;
        return true;
    }
    out_until->amount = strtod(text, &end);
    if (end == text || !isfinite(out_until->amount) || out_until->amount <= 0) return false;
    if (!strcmp(end, "spp"))
        out_until->kind = DMN_UNTIL_PATHS;
    else if (!strcmp(end, "s"))
        out_until->kind = DMN_UNTIL_SECONDS;
    return out_until->kind != DMN_UNTIL_STOPPED;
}

double dmn_until_share(const struct dmn_until *until, const struct dmn_progress *progress)
{
    double share = 0;

    switch (until->kind) {
    case DMN_UNTIL_STOPPED:
        break;
    case DMN_UNTIL_PATHS:
        share = (double)progress->paths / (until->amount * (double)progress->pixels);
        break;
    case DMN_UNTIL_SECONDS:
        share = progress->seconds / until->amount;
        break;
    case DMN_UNTIL_CONVERGED:
        share = progress->tiles ? (double)progress->converged / progress->tiles : 0;
        break;
    case DMN_UNTIL_END:
        share = progress->gaze_ended;
        break;
    }
    return fmin(share, 1);
}
