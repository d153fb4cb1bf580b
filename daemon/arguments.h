/* arguments: what the options of fovead's command line take that is neither a number nor a text. Each
 * function reads text into the struct dmn_options at values, as struct dmn_option's take() says. */
#ifndef FOVEAD_DAEMON_ARGUMENTS_H
#define FOVEAD_DAEMON_ARGUMENTS_H

#include "option.h"

bool dmn_take_sun(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_camera(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_fov(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_size(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_mode(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_listen(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_tls(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_tev(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_until(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_save(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_planes(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_clock(const struct dmn_option *option, const char *text, void *values, char *out_error);

/* The values that --mode and --gaze take, by index from 0, and half a line on each; NULL after the last. */
const char *dmn_mode_at(size_t index, const char **out_summary);
const char *dmn_gaze_usage_at(size_t index, const char **out_summary);

#endif
