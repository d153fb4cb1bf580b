/* Looking for the files that a scene names. */
#include "import/find_file.h"
#include "import/open_file.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static bool is_file(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

static bool join(const char *directory, const char *name, char out[RND_PATH_SIZE])
{
    return snprintf(out, RND_PATH_SIZE, "%s%s", directory, name) < RND_PATH_SIZE;
}

/* Undo %20 and the like, in place. */
static void decode_percent(char *text)
{
    char *to = text;
    for (const char *from = text; *from; to++) {
        unsigned byte;
        if (*from == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]) &&
            sscanf(from + 1, "%2x", &byte) == 1 && byte != 0) {
            *to = (char)byte;
            from += 3;
        } else {
            *to = *from++;
        }
    }
    *to = 0;
}

/* False for /a/b, C:/a/b, //a/b and file:///a/b. */
static bool is_relative(const char *name)
{
    const size_t scheme = strcspn(name, ":/");
    return name[0] != '/' && name[scheme] != ':';
}

/* Append to a folder the entry that has this name in another letter case; of several the first in order of
 * bytes. */
static bool append_entry(char path[RND_PATH_SIZE], const char *name)
{
    const size_t used = strlen(path);
    char best[256] = "";
    struct dirent *entry;
    DIR *folder = opendir(used ? path : ".");
    while (folder && (entry = readdir(folder)))
        if (strcasecmp(entry->d_name, name) == 0 && (!*best || strcmp(entry->d_name, best) < 0))
            snprintf(best, sizeof best, "%.255s", entry->d_name);
    if (folder) closedir(folder);
    return *best && snprintf(path + used, RND_PATH_SIZE - used, "%s", best) < (int)(RND_PATH_SIZE - used);
}

/* Find the file of that relative name in any letter case. */
static bool find_any_case(const char *directory, const char *name, char out[RND_PATH_SIZE])
{
    char names[RND_PATH_SIZE], *rest = names;
    if (!join("", name, names) || !join(directory, "", out)) return false;
    for (char *part; (part = strsep(&rest, "/"));) {
        const size_t used = strlen(out), room = RND_PATH_SIZE - used;
        struct stat status;
        if (!*part) continue;
        if (snprintf(out + used, room, "%s", part) >= (int)room) return false;
        if (stat(out, &status) != 0) {
            out[used] = 0;
            if (!append_entry(out, part)) return false;
        }
        const size_t length = strlen(out);
        if (rest && length + 1 < RND_PATH_SIZE) memcpy(out + length, "/", 2);
    }
    return is_file(out);
}

const char *rnd_why_not_found(const char *path)
{
    const char *why = rnd_why_closed(path);
    return why ? why : strerrordesc_np(ENOENT);
}

bool rnd_find_file(const char *directory, const char *name, bool of_uri, char out[RND_PATH_SIZE])
{
    char plain[RND_PATH_SIZE];
    if (is_relative(name) && join(directory, name, out) && is_file(out)) return true;
    if (join("", name, plain)) {
        if (of_uri) decode_percent(plain);
        if (is_relative(plain) && join(directory, plain, out) && is_file(out)) return true;
        for (char *c = plain; *c; c++)
            if (*c == '\\') *c = '/';
        const bool relative = is_relative(plain);
        if (!relative && !of_uri && join("", plain, out) && is_file(out)) return true;
        if (relative && find_any_case(directory, plain, out)) return true;
        const char *slash = strrchr(plain, '/');
        if ((slash || !relative) && find_any_case(directory, slash ? slash + 1 : plain, out)) return true;
        if (join(relative ? directory : "", plain, out)) return false;
    }
    snprintf(out, RND_PATH_SIZE, "%.*s", RND_PATH_SIZE - 1, name);
    return false;
}
