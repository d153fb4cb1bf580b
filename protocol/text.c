/* text.c: error lines, and peers' text made fit to print. */
#include "internal.h"

#include <stdarg.h>
#include <stdio.h>

void pro_clean(char *text)
{
    for (unsigned char *c = (unsigned char *)text, before = 0; *c; before = *c++) {
        const bool pair = c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0; /* C1 as UTF-8 */
        const bool alone = *c >= 0x80 && *c < 0xa0 && before < 0x80;   /* and as a byte */
        if (pair) c[1] = '?';
        if (pair || alone || *c < 0x20 || *c == 0x7f) *c = '?';
    }
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
