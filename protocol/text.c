/* text.c: error lines, and peers' text made fit to print. */
#include "internal.h"

#include <stdarg.h>
#include <stdio.h>

void pro_clean(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < 0x20 || *text == 0x7f) *text = '?';
}

bool pro_fail(char out_error[PRO_ERROR_SIZE], const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out_error, PRO_ERROR_SIZE, format, arguments);
    va_end(arguments);
    pro_clean(out_error);
    return false;
}
