/* plug: run a program among fake eye trackers that come and go.
 *
 *   plug [ACTION...] -- COMMAND [ARGUMENT...]
 *
 * The program starts at the action "run"; actions before it come earlier. Actions are done one after another:
 *   KIND[:HZ]   plug in a tracker: still, hid, unready, garbage, broken, psvr2, psvr2-late,
 *               psvr2-stuck; at HZ, or 500
 *   out:KIND    unplug the last one of this kind
 *   taken:N     wait until the program has read N reports of the last tracker, or with +N as many more
 *   said:TEXT   wait until stderr, which must be a file, contains TEXT
 *   file:PATH   wait until this file exists
 *   ok          make the last tracker ready
 * Two actions hold wherever they stand: "end" sends SIGTERM after the last action, and "repeat:N" does all
 * actions after "run" N times. At the end plug waits for the program, prints what the first eight trackers
 * were asked for, and exits with the program's exit code. */
#include "fake.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { MAX_PLUGGED = 4096 };

struct plug {
    struct fake *fake;
    struct {
        enum fake_kind kind;
        struct fake_device *device;
    } plugged[MAX_PLUGGED];
    int count;
    pid_t child;
    int status; /* of its end */
    bool ended;
};

static void usage(const char *what)
{
    fprintf(stderr, "plug: %s; usage: plug [ACTION...] -- COMMAND [ARGUMENT...]\n", what);
    exit(2);
}

/* A moment. */
static void rest(struct plug *plug)
{
    struct timespec tick = {.tv_nsec = 5000000};
    if (plug->child > 0 && waitpid(plug->child, &plug->status, WNOHANG) == plug->child) plug->ended = true;
    nanosleep(&tick, NULL);
}

/* Does stderr, which is a file, contain the text? */
static bool is_said(const char *text)
{
    static char said[1 << 20];
    int file = open("/proc/self/fd/2", O_RDONLY | O_CLOEXEC);
    ssize_t size = file < 0 ? -1 : pread(file, said, sizeof said - 1, 0);
    if (size < 0) usage("said: stderr is not a readable file");
    close(file);
    said[size] = '\0';
    return strstr(said, text);
}

static int find_kind(const char *name)
{
    for (int kind = 0; kind < FAKE_KINDS; kind++) {
        size_t length = strlen(fake_kind_names[kind]);
        if (strncmp(name, fake_kind_names[kind], length) == 0 &&
            (name[length] == '\0' || name[length] == ':'))
            return kind;
    }
    usage("unknown action");
    return 0;
}

static void plug_in(struct plug *plug, const char *action)
{
    int kind = find_kind(action);
    const char *colon = strchr(action, ':');
    double hz = colon ? atof(colon + 1) : 500;
    if (!(hz > 0) || plug->count == MAX_PLUGGED) usage("a bad rate, or too many devices");
    plug->plugged[plug->count].kind = kind;
    plug->plugged[plug->count++].device = fake_plug(plug->fake, kind, hz);
}

static void take_out(struct plug *plug, enum fake_kind kind)
{
    for (int i = plug->count - 1; i >= 0; i--)
        if (plug->plugged[i].kind == kind) {
            fake_unplug(plug->plugged[i].device);
            return;
        }
    usage("out: no tracker of this kind was plugged in");
}

static void start(struct plug *plug, char **command)
{
    plug->child = fork();
    if (plug->child < 0) usage("cannot fork");
    if (plug->child > 0) return;
    setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
    execvp(command[0], command);
    perror(command[0]);
    _exit(127);
}

/* Is it done in its turn? */
static bool is_in_turn(const char *action)
{
    return strcmp(action, "end") != 0 && strncmp(action, "repeat:", 7) != 0;
}

static struct fake_device *last(const struct plug *plug)
{
    if (!plug->count) usage("nothing is plugged in");
    return plug->plugged[plug->count - 1].device;
}

/* Wait until the program has read this many reports of the last tracker, or with a + so many more. */
static void await_taken(struct plug *plug, const char *number)
{
    uint64_t enough = strtoull(number, NULL, 10) + (*number == '+' ? fake_taken(last(plug)) : 0);
    while (!plug->ended && fake_taken(last(plug)) < enough) rest(plug);
}

static void act(struct plug *plug, const char *action)
{
    if (strncmp(action, "taken:", 6) == 0)
        await_taken(plug, action + 6);
    else if (strncmp(action, "said:", 5) == 0)
        while (!plug->ended && !is_said(action + 5)) rest(plug);
    else if (strncmp(action, "file:", 5) == 0)
        while (!plug->ended && access(action + 5, F_OK) != 0) rest(plug);
    else if (strcmp(action, "ok") == 0)
        fake_make_ready(last(plug));
    else if (strncmp(action, "out:", 4) == 0)
        take_out(plug, find_kind(action + 4));
    else
        plug_in(plug, action);
}

int main(int count, char **arguments)
{
    struct plug plug = {0};
    int end = 1, run = 0, repeats = 1;
    bool ends = false;
    while (end < count && strcmp(arguments[end], "--") != 0) {
        if (strcmp(arguments[end], "run") == 0) run = end;
        if (strncmp(arguments[end], "repeat:", 7) == 0) repeats = atoi(arguments[end] + 7);
        if (strcmp(arguments[end], "end") == 0) ends = true;
        end++;
    }
    if (end + 1 >= count) usage("no command");
    if (!run) run = end;
    plug.fake = fake_create();
    for (int i = 1; i < run; i++)
        if (is_in_turn(arguments[i])) act(&plug, arguments[i]);
    start(&plug, arguments + end + 1);
    for (int repeat = 0; repeat < repeats; repeat++)
        for (int i = run + 1; i < end && !plug.ended; i++)
            if (is_in_turn(arguments[i])) act(&plug, arguments[i]);
    if (ends && !plug.ended) kill(plug.child, SIGTERM);
    while (!plug.ended) rest(&plug);
    for (int i = 0; i < plug.count && i < 8; i++) {
        unsigned starts, stops;
        size_t calibration;
        fake_requests(plug.plugged[i].device, &starts, &stops, &calibration);
        fprintf(stderr, "plug: %s: started %u, stopped %u, calibration of %zu bytes\n",
                fake_kind_names[plug.plugged[i].kind], starts, stops, calibration);
    }
    fake_destroy(plug.fake);
    return WIFEXITED(plug.status) ? WEXITSTATUS(plug.status) : 128 + WTERMSIG(plug.status);
}
