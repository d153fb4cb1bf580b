/* options: fovead's command line. */
#ifndef FOVEAD_DAEMON_OPTIONS_H
#define FOVEAD_DAEMON_OPTIONS_H

#include "settings.h"

enum dmn_parsed { DMN_RUN, DMN_LIST, DMN_ANSWERED, DMN_REFUSED };

/* Strings in *out_options point into argv. DMN_LIST: only list eye trackers. DMN_ANSWERED after --help or
 * --version (exit 0), DMN_REFUSED after one line on stderr (exit 2). */
enum dmn_parsed dmn_options_parse(int argc, char **argv, struct dmn_options *out_options);

#endif
