/* print: text for people. */
#ifndef FOVEAD_DAEMON_PRINT_H
#define FOVEAD_DAEMON_PRINT_H

#include <stdarg.h>
#include <stdio.h>

/* As fprintf(), but control characters other than line ends become blanks: names come from files, devices and
 * peers, and must not drive a terminal. */
void dmn_print(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
void dmn_vprint(FILE *out, const char *format, va_list arguments);

#endif
