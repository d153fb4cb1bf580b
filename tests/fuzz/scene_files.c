/* Fuzzing of the whole program with scene files of all formats. fovead either draws a spoiled file and exits
 * with 0, or prints one line and exits with 1. A fovead that watches a folder survives every file that is put
 * there.
 *
 *   fuzz_scene_files FOVEAD [start|watch [COUNT [FIRST]]]
 *
 * Every folder of corpus/scene is a scene: a file called scene, and the files that it names. Spoiled scene
 * number n is always the same. COUNT of them are tried, from number FIRST on. A failure is reported with its
 * number, and its files are kept. */
#include "fuzz.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum {
    ROOM = 1 << 16, /* bytes of a file */
    MOST_SETS = 64,
    MOST_FILES = 8,
    READER_MIB = 1024,
    READER_SECONDS = 4,
    OWN_MIB = 512,     /* what fovead itself may use beyond its reader */
    PATIENCE_S = 1200, /* a program that takes longer hangs */
    GOOD = -1          /* stands for the unspoiled scene */
};

struct set {
    char name[64];
    int count;
    char file[MOST_FILES][64];
    char scene[64]; /* the file that is given to --scene */
    bool has_env;   /* env.hdr is given to --env */
};

static struct set sets[MOST_SETS];
static int set_count;
static char place[] = "/tmp/fuzz_scene.XXXXXX";
static const char *fovead;

/* --- seeds --- */

static void find_sets(void)
{
    struct dirent **folder, **entry;
    const int folders = scandir(CORPUS, &folder, NULL, alphasort);
    for (int i = 0; i < folders; free(folder[i++])) {
        char path[512];
        struct set *set = &sets[set_count];
        if (folder[i]->d_name[0] == '.' || set_count == MOST_SETS) continue;
        snprintf(path, sizeof path, "%s/%.60s", CORPUS, folder[i]->d_name);
        snprintf(set->name, sizeof set->name, "%.60s", folder[i]->d_name);
        const int files = scandir(path, &entry, NULL, alphasort);
        for (int k = 0; k < files; free(entry[k++])) {
            if (entry[k]->d_name[0] == '.' || set->count == MOST_FILES) continue;
            snprintf(set->file[set->count], sizeof set->file[0], "%.60s", entry[k]->d_name);
            const char *name = set->file[set->count++];
            if (strncmp(name, "scene.", 6) == 0 && !strstr(name, ".mtl") && !strstr(name, ".bin"))
                strcpy(set->scene, name);
            if (strcmp(name, "env.hdr") == 0) set->has_env = true;
        }
        if (files >= 0) free(entry);
        if (*set->scene) set_count++;
    }
    if (folders >= 0) free(folder);
    if (set_count == 0) exit((fprintf(stderr, "%s: holds no scenes\n", CORPUS), 1));
}

/* Write a set into the folder, with one of its files spoiled as the number says. Each file appears whole. */
static void put(const struct set *set, int number, const char *into)
{
    static uint8_t bytes[2 * ROOM];
    uint64_t state = 360 + (uint64_t)(number + 1) * 7919;
    const int spoiled = number == GOOD ? -1 : (int)(fuzz_noise(&state) % (uint64_t)set->count);
    for (int turn = 0; turn < 2; turn++) /* the scene last, because writing it starts the reading */
        for (int k = 0; k < set->count; k++) {
            char path[512], part[520];
            if ((strcmp(set->file[k], set->scene) == 0) != turn) continue;
            snprintf(path, sizeof path, "%s/%s/%s", CORPUS, set->name, set->file[k]);
            FILE *from = fopen(path, "rb");
            size_t size = from ? fread(bytes, 1, ROOM, from) : 0;
            if (from) fclose(from);
            for (uint64_t hits = k == spoiled ? 1 + fuzz_noise(&state) % 3 : 0; hits > 0 && size > 0; hits--)
                size = fuzz_noise(&state) % 2 ? fuzz_spoil(&state, bytes, size, ROOM)
                                              : fuzz_spoil_number(&state, (char *)bytes, size, ROOM);
            snprintf(path, sizeof path, "%s/%s", into, set->file[k]);
            snprintf(part, sizeof part, "%s.part", path);
            FILE *to = fopen(part, "wb");
            if (!to || fwrite(bytes, 1, size, to) != size || fclose(to) != 0 || rename(part, path) != 0)
                exit((perror(path), 1));
        }
}

/* --- the program --- */

static int fail(int number, const struct set *set, const char *what)
{
    fprintf(stderr, "number %d (%s): %s; its files are in %s\n", number, set->name, what, place);
    return 1;
}

/* The whole content of a file of output. */
static const char *content(const char *name)
{
    enum { MOST = 1 << 22 };
    static char text[MOST + 1];
    char path[512];
    snprintf(path, sizeof path, "%s/%s", place, name);
    FILE *file = fopen(path, "rb");
    text[file ? fread(text, 1, MOST, file) : 0] = 0;
    if (file) fclose(file);
    return text;
}

static int times(const char *text, const char *word)
{
    int count = 0;
    for (; (text = strstr(text, word)); text += strlen(word)) count++;
    return count;
}

static pid_t run(const struct set *set, const char *const *more)
{
    static char scene[512], env[512], log[2][512], mib[16], seconds[16];
    const char *arguments[40] = {fovead,  "--scene",       scene,      "--size",    "128",
                                 "--sun", "0,45,5,1",      "--camera", "0,3,0",     "--reader-memory",
                                 mib,     "--reader-time", seconds,    "--threads", "1"};
    int n = 15;
    posix_spawn_file_actions_t actions;
    pid_t pid;
    snprintf(scene, sizeof scene, "%s/%s", place, set->scene);
    snprintf(env, sizeof env, "%s/env.hdr", place);
    snprintf(mib, sizeof mib, "%d", READER_MIB);
    snprintf(seconds, sizeof seconds, "%d", READER_SECONDS);
    if (set->has_env) arguments[n++] = "--env", arguments[n++] = env;
    while (*more) arguments[n++] = *more++;
    for (int i = 0; i < 2; i++) {
        snprintf(log[i], sizeof log[i], "%s/%s", place, i ? "err" : "out");
        unlink(log[i]);
    }
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    for (int i = 0; i < 2; i++)
        posix_spawn_file_actions_addopen(&actions, 1 + i, log[i], O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (posix_spawn(&pid, fovead, &actions, NULL, (char *const *)(uintptr_t)arguments, environ) != 0)
        exit((perror(fovead), 1));
    posix_spawn_file_actions_destroy(&actions);
    return pid;
}

/* Wait for a process, and return its status. Returns -1 if it hung and was killed. */
static int end_of(pid_t pid, long *out_kib)
{
    struct rusage usage;
    const struct timespec step = {0, 20000000};
    const time_t last = time(NULL) + PATIENCE_S;
    int status = 0;
    while (wait4(pid, &status, WNOHANG, &usage) == 0) {
        if (time(NULL) > last) {
            kill(pid, SIGKILL);
            waitpid(pid, &status, 0);
            return -1;
        }
        nanosleep(&step, NULL);
    }
    *out_kib = usage.ru_maxrss; /* includes its readers, which it has waited for */
    return status;
}

/* Does the text contain bytes that control a terminal? */
static bool speaks_to_terminal(const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c; c++)
        if ((*c < ' ' && *c != '\n') || *c == 0x7f || (*c == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0))
            return true;
    return false;
}

/* --- one start per scene --- */

static int refused, drawn, ended; /* results; `ended`: its reader was ended */
static long most_kib;

static int start_one(int number)
{
    static const char *const more[] = {"--until", "1spp", "--clock", "virtual", NULL};
    const struct set *set = &sets[number % set_count];
    put(set, number, place);
    long kib = 0;
    const int status = end_of(run(set, more), &kib);
    const char *err = content("err");
    if (kib > most_kib) most_kib = kib;
    if (status == -1) return fail(number, set, "it hangs");
    if (!WIFEXITED(status) || WEXITSTATUS(status) > 1)
        return fail(number, set, "it ends by a signal or with a status of its own");
    if (kib > (READER_MIB + OWN_MIB) * 1024L) return fail(number, set, "it takes more memory than it may");
    if (speaks_to_terminal(err)) return fail(number, set, "it writes control characters");
    if (WEXITSTATUS(status) == 0) return drawn++, 0;
    refused++;
    ended += times(err, "the reader ") > 0;
    if (times(err, "\n") != 1 || strncmp(err, "fovead: ", 8) != 0)
        return fail(number, set, "it does not say one line");
    return 0;
}

/* --- watched --- */

static int answers(void)
{
    return times(content("out"), "scene    ") + times(content("err"), "the picture stays: ");
}

/* Wait for one more answer. Returns false if the process hangs or has gone. */
static bool await(pid_t pid, int before)
{
    const struct timespec step = {0, 20000000};
    const time_t last = time(NULL) + PATIENCE_S;
    while (answers() == before) {
        if (waitpid(pid, NULL, WNOHANG) != 0 || time(NULL) > last) return false;
        nanosleep(&step, NULL);
    }
    return true;
}

/* Put all spoiled scenes of this set before one daemon, one after the other. */
static int watch_set(const struct set *set, int first, int count)
{
    char address[600];
    snprintf(address, sizeof address, "unix:%s/socket", place);
    const char *const more[] = {"--watch", "--gaze", "pointer", "--listen", address, NULL};
    put(set, GOOD, place);
    const pid_t pid = run(set, more);
    if (!await(pid, 0)) return fail(GOOD, set, "it does not start");
    for (int number = first; number < first + count; number++) {
        if (&sets[number % set_count] != set) continue;
        const int before = answers();
        put(set, number, place);
        if (!await(pid, before)) return fail(number, set, "the daemon hangs or has gone");
        if (speaks_to_terminal(content("err"))) return fail(number, set, "it writes control characters");
    }
    const int before = answers();
    put(set, GOOD, place);
    if (!await(pid, before)) return fail(GOOD, set, "the daemon does not go on");
    kill(pid, SIGTERM);
    long kib = 0;
    const int status = end_of(pid, &kib);
    if (kib > most_kib) most_kib = kib;
    drawn += times(content("out"), "scene    ");
    refused += times(content("err"), "the picture stays: ");
    ended += times(content("err"), "the reader ");
    if (status != 0) return fail(GOOD, set, "the daemon does not end in order");
    return kib <= (READER_MIB + 2 * OWN_MIB) * 1024L ? 0
                                                     : fail(GOOD, set, "it takes more memory than it may");
}

int main(int count, char **argument)
{
    const bool watch = count > 2 && strcmp(argument[2], "watch") == 0;
    const int many = count > 3 ? atoi(argument[3]) : 60, first = count > 4 ? atoi(argument[4]) : 0;
    int bad = 0;
    if (count < 2 || !mkdtemp(place))
        return fprintf(stderr, "usage: fuzz_scene_files FOVEAD [start|watch [COUNT [FIRST]]]\n"), 2;
    fovead = argument[1];
    find_sets();
    for (int number = first; !watch && !bad && number < first + many; number++) bad = start_one(number);
    for (int i = 0; watch && !bad && i < set_count; i++) bad = watch_set(&sets[i], first, many);
    printf(
        "%d files of %d formats: %d drawn, %d refused, of these %d whose reader was ended; at most %ld MiB\n",
        many, set_count, drawn, refused, ended, most_kib / 1024);
    if (!bad) {
        char command[64];
        snprintf(command, sizeof command, "rm -r %s", place);
        bad = system(command) != 0;
    }
    return bad;
}
