/* Files that appear whole or not at all. */
#include "file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

enum { DIGITS = 8, TRIES = 100 };
static const char MARK[] = ".fovead-", END[] = ".part"; /* before and after the digits of a part's name */

static bool fail(char out_error[DMN_FILE_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Write one line, even if the path has line ends. */
static bool fail(char out_error[DMN_FILE_ERROR_SIZE], const char *format, ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(out_error, DMN_FILE_ERROR_SIZE, format, args);
    va_end(args);
    for (char *c = out_error; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
    return false;
}

static bool cannot(const char *path, char out_error[DMN_FILE_ERROR_SIZE])
{
    return fail(out_error, "%.300s: cannot be written: %s", path, strerror(errno));
}

/* The folder of a path, open. */
static int open_folder(const char *path)
{
    char *copy = strdup(path);
    int fd = copy ? open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;

    free(copy);
    return fd;
}

/* --- what is there already --- */

/* Is this the name of a part, of whatever file? */
static bool is_part(const char *entry)
{
    size_t length = strlen(entry), tail = strlen(MARK) + DIGITS + strlen(END);
    const char *digits = length > tail ? entry + length - DIGITS - strlen(END) : entry;

    return length > tail && !strncmp(digits - strlen(MARK), MARK, strlen(MARK)) &&
           strspn(digits, "0123456789abcdef") == DIGITS && !strcmp(digits + DIGITS, END);
}

/* Open and lock a part of this user's that no program has locked; -1 if it is no such file. */
static int open_abandoned(int folder, const char *entry)
{
    int fd = openat(folder, entry, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    struct stat status;
    bool abandoned = fd >= 0 && !fstat(fd, &status) && S_ISREG(status.st_mode) &&
                     status.st_uid == geteuid() && !flock(fd, LOCK_EX | LOCK_NB);

    if (abandoned || fd < 0) return fd;
    close(fd);
    return -1;
}

/* Remove parts that killed programs have left in the folder of path. */
static void remove_leftovers(const char *path)
{
    int fd = open_folder(path);
    DIR *folder = fd >= 0 ? fdopendir(fd) : NULL;
    struct dirent *entry;

    while (folder && (entry = readdir(folder))) {
        int part = is_part(entry->d_name) ? open_abandoned(fd, entry->d_name) : -1;

        if (part < 0) continue;
        unlinkat(fd, entry->d_name, 0);
        close(part);
    }
    if (folder)
        closedir(folder);
    else if (fd >= 0)
        close(fd);
}

/* A recording holds its lock as long as it goes on. */
static bool is_locked(const char *path)
{
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    bool locked = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) && errno == EWOULDBLOCK;

    if (fd >= 0) close(fd);
    return locked;
}

bool dmn_file_check(const char *path, bool replace, char out_error[DMN_FILE_ERROR_SIZE])
{
    struct stat entry, file;
    int folder = open_folder(path);
    bool good = folder >= 0 && !faccessat(folder, ".", W_OK | X_OK, AT_EACCESS);

    if (!good) cannot(path, out_error);
    if (folder >= 0) close(folder);
    if (!good) return false;
    remove_leftovers(path);
    if (lstat(path, &entry)) return errno == ENOENT || cannot(path, out_error);
    if (S_ISLNK(entry.st_mode) ? !stat(path, &file) && !S_ISREG(file.st_mode) : !S_ISREG(entry.st_mode))
        return fail(out_error, "%.300s: not a regular file, expected a place for one", path);
    if (is_locked(path))
        return fail(out_error, "%.300s: is being recorded already, expected another file", path);
    if (!replace) return fail(out_error, "%.300s: exists, expected another name or --replace", path);
    return true;
}

/* --- writing --- */

static bool name_part(struct dmn_file *file)
{
    uint32_t number;

    free(file->part);
    file->part = NULL;
    return getrandom(&number, sizeof(number), 0) == sizeof(number) &&
           asprintf(&file->part, "%s%s%08x%s", file->path, MARK, (unsigned)number, END) >= 0;
}

/* A file without a name can be given one only by way of /proc. */
static int open_unnamed(const char *path, mode_t mode)
{
    char *copy = access("/proc/self/fd", X_OK) ? NULL : strdup(path);
    int fd = copy ? open(dirname(copy), O_TMPFILE | O_RDWR | O_CLOEXEC, mode) : -1;

    free(copy);
    return fd;
}

/* Open a part, locked so that no other program removes it as abandoned; one that did so before the lock has
 * removed it. */
static int open_named(struct dmn_file *file, mode_t mode)
{
    struct stat status;

    for (int i = 0; i < TRIES; i++) {
        int fd =
            name_part(file) ? open(file->part, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode) : -1;

        if (fd < 0 && errno != EEXIST) return -1;
        if (fd < 0) continue;
        (void)!flock(fd, LOCK_EX); /* not every file system has locks */
        if (fstat(fd, &status) || status.st_nlink) return fd;
        close(fd);
    }
    return -1;
}

static void finish(struct dmn_file *file)
{
    if (file->file) fclose(file->file);
    free(file->path);
    free(file->part);
    *file = (struct dmn_file){0};
}

bool dmn_file_begin(struct dmn_file *file, const char *path, mode_t mode, bool replace,
                    char out_error[DMN_FILE_ERROR_SIZE])
{
    int fd;

    *file = (struct dmn_file){.path = strdup(path), .replace = replace};
    if (!file->path) return fail(out_error, "%.300s: out of memory", path);
    if (!dmn_file_check(path, replace, out_error)) {
        finish(file);
        return false;
    }
    fd = open_unnamed(path, mode);
    if (fd < 0) {
        fd = open_named(file, mode);
        file->named = fd >= 0;
    }
    if (fd >= 0) {
        (void)!flock(fd, LOCK_EX | LOCK_NB); /* not every file system has locks */
        file->file = fdopen(fd, "w");
    }
    if (file->file) return true;
    cannot(path, out_error);
    if (fd >= 0) close(fd);
    dmn_file_drop(file);
    return false;
}

void dmn_file_drop(struct dmn_file *file)
{
    if (file->named) unlink(file->part);
    finish(file);
}

/* Give a file without a name that of a part. It could get the path at once if that is free, but programs that
 * watch for files that are closed or moved there would not notice. */
static bool give_name(struct dmn_file *file)
{
    char self[32];

    snprintf(self, sizeof(self), "/proc/self/fd/%d", fileno(file->file));
    for (int i = 0; i < TRIES && !file->named && (i == 0 || errno == EEXIST); i++)
        file->named = name_part(file) && !linkat(AT_FDCWD, self, AT_FDCWD, file->part, AT_SYMLINK_FOLLOW);
    return file->named;
}

static bool move_into_place(struct dmn_file *file)
{
    unsigned flags = file->replace ? 0 : RENAME_NOREPLACE;
    bool moved;

    if (!file->named && !give_name(file)) return false;
    moved = !renameat2(AT_FDCWD, file->part, AT_FDCWD, file->path, flags);
    /* If the file system cannot check that the path is free, rely on the check of dmn_file_begin(). */
    if (!moved && (errno == EINVAL || errno == ENOSYS)) moved = !rename(file->part, file->path);
    if (moved) file->named = false;
    return moved;
}

/* Sync the folder, so that the file's new name is on the disk. Not every file system can do so. */
static bool sync_folder(const char *path)
{
    int fd = open_folder(path);
    bool good = fd >= 0 && (!fsync(fd) || errno == EINVAL);

    if (fd >= 0) close(fd);
    return good;
}

/* stdio remembers that a write failed, but not why: write again to learn it. */
bool dmn_file_is_written(FILE *file)
{
    if (fflush(file)) return false;
    if (!ferror(file)) return true;
    if (write(fileno(file), "\n", 1) == 1) errno = EIO;
    return false;
}

static bool settle(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE])
{
    return (dmn_file_is_written(file->file) && !fsync(fileno(file->file)) && move_into_place(file) &&
            sync_folder(file->path)) ||
           cannot(file->path, out_error);
}

bool dmn_file_end(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE])
{
    bool good = settle(file, out_error);

    dmn_file_drop(file);
    return good;
}

int dmn_file_keep(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE])
{
    int fd = fcntl(fileno(file->file), F_DUPFD_CLOEXEC, 3);

    if (fd < 0) {
        cannot(file->path, out_error);
    } else if (!settle(file, out_error)) {
        close(fd);
        fd = -1;
    }
    dmn_file_drop(file);
    return fd;
}
