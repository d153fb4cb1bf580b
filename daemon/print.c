/* Text for people. */
#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "renderer.h"

void dmn_vprint(FILE *out, const char *format, va_list arguments)
{
    char *text;

    if (vasprintf(&text, format, arguments) < 0) return;
    for (char *line = text, *end, last; *line; line = end) { /* but for line ends */
        end = strchrnul(line, '\n');
        last = *end;
        *end = '\0';
        rnd_make_printable(line);
        if ((*end = last)) end++;
    }
    fputs(text, out);
    free(text);
}

void dmn_print(FILE *out, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    dmn_vprint(out, format, arguments);
    va_end(arguments);
}
