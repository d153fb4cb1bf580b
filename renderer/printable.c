/* Makes text that comes from files safe for terminals. */
#include "renderer.h"

void rnd_make_printable(char *text)
{
    for (unsigned char *c = (unsigned char *)text, before = 0; *c; before = *c++) {
        const bool high = c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0, /* C1 as UTF-8 */
            alone = *c >= 0x80 && *c < 0xa0 && before < 0x80;          /* and as a byte */
        if (high) c[1] = ' ';
        if (high || alone || *c < ' ' || *c == 0x7f) *c = ' ';
    }
}
