/* Signals that end a command in order. */
#include "ctl.h"

volatile sig_atomic_t ctl_interrupted;

static void on_signal(int number)
{
    ctl_interrupted = number;
}

void ctl_catch_signals(void)
{
    const struct sigaction action = {.sa_handler = on_signal};
    struct sigaction before;

    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* After nohup(1) the command goes on when the terminal is closed. */
    if (!sigaction(SIGHUP, NULL, &before) && before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, NULL);
}
