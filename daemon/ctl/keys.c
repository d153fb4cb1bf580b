/* Single keys from a terminal, read as they are pressed, without echo. */
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#include "ctl.h"

static struct termios before;
static bool changed;

static void restore(void)
{
    if (changed) tcsetattr(STDIN_FILENO, TCSANOW, &before);
    changed = false;
}

bool ctl_keys_begin(void)
{
    struct termios now;

    /* In the background, changing the terminal would stop this program. */
    if (!isatty(STDIN_FILENO) || tcgetpgrp(STDIN_FILENO) != getpgrp() || tcgetattr(STDIN_FILENO, &before))
        return false;
    now = before;
    now.c_lflag &= (tcflag_t) ~(ICANON | ECHO);
    now.c_cc[VMIN] = now.c_cc[VTIME] = 0;
    atexit(restore);
    changed = !tcsetattr(STDIN_FILENO, TCSANOW, &now);
    return changed;
}

void ctl_keys_end(void)
{
    restore();
}

/* An arrow comes as three bytes: escape, '[' or 'O', and a letter. */
static char arrow(void)
{
    static const char LETTER[] = "ABCD", MEANS[] = "wsda";
    const char *at = NULL;
    char rest[2];

    if (read(STDIN_FILENO, rest, 2) == 2 && (rest[0] == '[' || rest[0] == 'O') && rest[1])
        at = strchr(LETTER, rest[1]);
    return at ? MEANS[at - LETTER] : '\0';
}

char ctl_key(void)
{
    char key;

    if (!changed || read(STDIN_FILENO, &key, 1) != 1) return '\0';
    return key == '\033' ? arrow() : key;
}
