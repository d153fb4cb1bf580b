/* Files appear whole or not at all, whatever happens: a full disk, a file that exists already, parts that
 * killed programs left behind. Every test runs twice: once with files that have no name until they are whole,
 * and once as on a file system that has no such files. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static bool no_tmpfile;
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);

int __wrap_open(const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    mode_t mode = flags & O_CREAT || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(args, mode_t) : 0;
    va_end(args);
    if (no_tmpfile && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return __real_open(path, flags, mode);
}

static char dir[64], path[96], error[DMN_FILE_ERROR_SIZE];

static int enter(void **state)
{
    no_tmpfile = *state;
    snprintf(dir, sizeof dir, "daemon_file.XXXXXX");
    if (!mkdtemp(dir)) return -1;
    snprintf(path, sizeof path, "%s/x.exr", dir);
    return 0;
}

/* How many files the folder holds. They are removed if do_remove is set. */
static int count_entries(bool do_remove)
{
    DIR *folder = opendir(dir);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(folder));) {
        if (!strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..")) continue;
        count++;
        if (do_remove) unlinkat(dirfd(folder), entry->d_name, 0);
    }
    closedir(folder);
    return count;
}

static int leave(void **state)
{
    (void)state;
    count_entries(true);
    return rmdir(dir);
}

static void put(const char *name, const char *text)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void holds(const char *name, const char *text)
{
    char found[64] = "";
    FILE *file = fopen(name, "r");
    assert_non_null(file);
    assert_int_equal(fread(found, 1, sizeof found - 1, file), strlen(text));
    fclose(file);
    assert_string_equal(found, text);
}

static void begin(struct dmn_file *file, bool replace)
{
    if (!dmn_file_begin(file, path, 0640, replace, error)) fail_msg("%s", error);
}

static void write_and_end(const char *text, bool replace)
{
    struct dmn_file file;
    begin(&file, replace);
    fputs(text, file.file);
    if (!dmn_file_end(&file, error)) fail_msg("%s", error);
}

static void appears_whole(void **state)
{
    (void)state;
    struct dmn_file file;
    struct stat status;
    const mode_t mask = umask(022);
    begin(&file, false);
    fputs("half", file.file);
    fflush(file.file);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(count_entries(false), no_tmpfile);
    fputs(" and half", file.file);
    assert_true(dmn_file_end(&file, error));
    umask(mask);
    holds(path, "half and half");
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
    assert_int_equal(status.st_nlink, 1);
    begin(&file, true);
    fputs("new", file.file);
    fflush(file.file);
    holds(path, "half and half");
    assert_true(dmn_file_end(&file, error));
    holds(path, "new");
    begin(&file, true);
    fputs("newer", file.file);
    dmn_file_drop(&file);
    holds(path, "new");
    assert_int_equal(count_entries(false), 1);
}

static void refuses(const char *name, bool replace, const char *word)
{
    struct dmn_file file;
    error[0] = '\0';
    assert_false(dmn_file_begin(&file, name, 0666, replace, error));
    assert_true(strstr(error, name) && strstr(error, word) && !strchr(error, '\n'));
    assert_false(dmn_file_check(name, replace, error));
}

static void refuses_what_is_there(void **state)
{
    (void)state;
    char name[128];
    put(path, "old");
    refuses(path, false, "exists");
    refuses(dir, true, "not a regular file");
    refuses("/dev/null", true, "not a regular file");
    snprintf(name, sizeof name, "%s/absent/x.exr", dir);
    refuses(name, true, "No such file");
    snprintf(name, sizeof name, "%s/x.exr/x.exr", dir);
    refuses(name, true, "Not a directory");
    snprintf(name, sizeof name, "%s/fifo", dir);
    assert_int_equal(mkfifo(name, 0600), 0);
    refuses(name, true, "not a regular file");
    snprintf(name, sizeof name, "%s/link", dir);
    assert_int_equal(symlink("fifo", name), 0);
    refuses(name, true, "not a regular file");
    holds(path, "old");
    assert_int_equal(count_entries(false), 3);
}

/* Another program creates the same file in the meantime. */
static void comes_second(void **state)
{
    (void)state;
    struct dmn_file file;
    begin(&file, false);
    fputs("mine", file.file);
    put(path, "theirs");
    assert_false(dmn_file_end(&file, error));
    assert_true(strstr(error, path) && strstr(error, "File exists"));
    holds(path, "theirs");
    assert_int_equal(count_entries(false), 1);
    begin(&file, true);
    fputs("mine", file.file);
    unlink(path);
    assert_true(dmn_file_end(&file, error));
    holds(path, "mine");
    assert_int_equal(count_entries(false), 1);
}

/* A full disk is reported, however much of the file was still buffered. The old file stays, and nothing else
 * is left behind. */
static void full_disk(void **state)
{
    (void)state;
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 10000;
    write_and_end("old", false);
    signal(SIGXFSZ, SIG_IGN);
    for (size_t size = 10001; size < 100000; size += 10000) {
        struct dmn_file file;
        begin(&file, true);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        for (size_t i = 0; i < size; i++) fputc('x', file.file);
        const bool ok = dmn_file_end(&file, error);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        assert_false(ok);
        assert_true(strstr(error, path) && strstr(error, "File too large"));
        holds(path, "old");
        assert_int_equal(count_entries(false), 1);
    }
    signal(SIGXFSZ, SIG_DFL);
}

/* A file that is kept open is whole from the start, and nothing replaces it while it is open. */
static void is_kept(void **state)
{
    (void)state;
    struct dmn_file file;
    write_and_end("old", false);
    begin(&file, true);
    fputs("head", file.file);
    const int fd = dmn_file_keep(&file, error);
    assert_true(fd > 2);
    holds(path, "head");
    assert_int_equal(count_entries(false), 1);
    assert_int_equal(write(fd, " and more", 9), 9);
    holds(path, "head and more");
    refuses(path, true, "is being recorded already");
    close(fd);
    write_and_end("new", true);
    holds(path, "new");
}

/* Parts that killed programs left in the folder are removed. Parts of running programs stay, and so do other
 * files with similar names. */
static void removes_leftovers(void **state)
{
    (void)state;
    static const char *const names[] = {
        "x.exr.fovead-0123abcd.part", "y.gaze.fovead-fedcba98.part", "x.exr.fovead-01234567.part",
        "x.exr.fovead-0123abcg.part", "x.exr.fovead-0123abc.part",   "x.exr.fovead-0123abcd.part2",
        "x.exr.0123abcd.part",        ".fovead-0123abcd.part",       "x.exr.fovead-89abcdef.part"};
    enum { COUNT = sizeof names / sizeof *names, LOCKED = 2, LINK = 8 };
    char name[COUNT][128];
    for (int i = 0; i < COUNT; i++) {
        snprintf(name[i], sizeof name[i], "%s/%s", dir, names[i]);
        if (i < LINK) put(name[i], "half");
    }
    assert_int_equal(symlink(names[LOCKED], name[LINK]), 0);
    const int fd = open(name[LOCKED], O_RDONLY);
    assert_int_equal(flock(fd, LOCK_EX), 0);
    if (!dmn_file_check(path, true, error)) fail_msg("%s", error);
    for (int i = 0; i < COUNT; i++) {
        struct stat status;
        assert_int_equal(lstat(name[i], &status), i < LOCKED ? -1 : 0);
    }
    close(fd);
    write_and_end("whole", true);
    assert_int_equal(access(name[LOCKED], F_OK), -1);
}

int main(void)
{
#define TEST(f)                                                                                              \
    {#f, f, enter, leave, NULL},                                                                             \
    {                                                                                                        \
#f " without O_TMPFILE", f, enter, leave, &no_tmpfile                                                \
    }
    const struct CMUnitTest tests[] = {
        TEST(appears_whole), TEST(refuses_what_is_there), TEST(comes_second), TEST(full_disk),
        TEST(is_kept),       TEST(removes_leftovers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
