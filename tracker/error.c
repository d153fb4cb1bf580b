/* One line of text for what went wrong. */
#include "error.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

bool trk_vfail(char out_error[TRK_ERROR_SIZE], const char *prefix, const char *format, va_list arguments)
{
    out_error[0] = '\0';
    strncat(out_error, prefix, TRK_ERROR_SIZE - 1);
    size_t length = strlen(out_error);
    vsnprintf(out_error + length, TRK_ERROR_SIZE - length, format, arguments);
    for (char *c = out_error; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
    return false;
}

bool trk_fail(char out_error[TRK_ERROR_SIZE], const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    trk_vfail(out_error, "", format, arguments);
    va_end(arguments);
    return false;
}
