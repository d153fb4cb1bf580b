/* Messages of one line that say what went wrong. */
#include "error.h"

#include <stdio.h>
#include <string.h>

void trk_make_printable(char *text)
{
    for (unsigned char *c = (unsigned char *)text, before = 0; *c; before = *c++) {
        const bool high = c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0, /* C1 as UTF-8 */
            alone = *c >= 0x80 && *c < 0xa0 && before < 0x80;          /* and as a byte */
        if (high) c[1] = '?';
        if (high || alone || *c < ' ' || *c == 0x7f) *c = '?';
    }
}

bool trk_vfail(char out_error[TRK_ERROR_SIZE], const char *prefix, const char *format, va_list arguments)
{
    out_error[0] = '\0';
    strncat(out_error, prefix, TRK_ERROR_SIZE - 1);
    size_t length = strlen(out_error);
    vsnprintf(out_error + length, TRK_ERROR_SIZE - length, format, arguments);
    trk_make_printable(out_error);
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
