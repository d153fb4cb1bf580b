/* error: one line of text that says what went wrong. Only for the files of tracker/. */
#ifndef FOVEAD_TRACKER_ERROR_H
#define FOVEAD_TRACKER_ERROR_H

#include "tracker.h"

#include <stdarg.h>

/* Write a message into out_error, cut to its size and kept to one line: control characters, which may come
 * from a path or a log, become '?'. Returns false, so that a failing function can return the result. */
bool trk_fail(char out_error[TRK_ERROR_SIZE], const char *format, ...) __attribute__((format(printf, 2, 3)));
bool trk_vfail(char out_error[TRK_ERROR_SIZE], const char *prefix, const char *format, va_list arguments)
    __attribute__((format(printf, 3, 0)));
/* Replace control characters (C0, DEL, and C1 as a byte or as UTF-8) by '?'. */
void trk_make_printable(char *text);

#endif
