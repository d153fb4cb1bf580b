/* BIDS's inheritance: the metadata of a table is in JSON files in its folder and in all folders above it, up
 * to the root of the dataset, which holds dataset_description.json. A file applies to all tables of its
 * suffix below it whose names have all entities of its own name. Of two files that have the same key, the
 * deeper one counts. (BIDS 1.10, common principles.) */
#include "log/bids_sidecar.h"

#include "error.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_SIDECAR = 1 << 20, MAX_LEVELS = 8, MAX_ENTITIES = 32 };

/* A file name split at "_": first the entities, last the suffix. */
struct name {
    char text[NAME_MAX + 1];
    const char *entities[MAX_ENTITIES];
    size_t count;
    const char *suffix;
};

/* False if the file name does not end in `end`, or is too long. */
static bool parse(struct name *name, const char *file, const char *end)
{
    size_t length = strlen(file), size = strlen(end);
    if (length <= size || length > NAME_MAX || strcmp(file + length - size, end) != 0) return false;
    snprintf(name->text, sizeof name->text, "%.*s", (int)(length - size), file);
    name->count = 0;
    char *at = name->text, *next;
    for (; (next = strchr(at, '_')); at = next + 1) {
        if (name->count == MAX_ENTITIES) return false;
        *next = '\0';
        name->entities[name->count++] = at;
    }
    name->suffix = at;
    return true;
}

static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static bool parse_table(struct name *name, const char *path)
{
    return parse(name, base_of(path), ".tsv.gz") || parse(name, base_of(path), ".tsv");
}

void trk_bids_suffix(const char *path, char out_suffix[32])
{
    struct name name;
    bool ok = parse_table(&name, path) && name.count > 0;
    snprintf(out_suffix, 32, "%s", ok ? name.suffix : "");
}

static bool applies(const struct name *file, const struct name *table, const char *suffix)
{
    if (strcmp(file->suffix, suffix ? suffix : table->suffix) != 0) return false;
    for (size_t i = 0; i < file->count; i++) {
        bool found = false;
        for (size_t k = 0; k < table->count && !found; k++)
            found = strcmp(file->entities[i], table->entities[k]) == 0;
        if (!found) return false;
    }
    return true;
}

/* The folders to search, starting with the table's own and going up to the root of the dataset. If no folder
 * has a dataset_description.json, the list ends with the folder above the subject's (sub-...); if there is no
 * subject's folder either, the list is only the table's own folder. */
static size_t find_levels(const char *path, char *out_levels[MAX_LEVELS])
{
    size_t length = (size_t)(base_of(path) - path), count = 0, above_subject = 1;
    char *folder = length ? strndup(path, length) : strdup("."),
         *level = folder ? realpath(folder, NULL) : NULL;
    free(folder);
    while (level && count < MAX_LEVELS) {
        char description[PATH_MAX + 64];
        snprintf(description, sizeof description, "%s/dataset_description.json", level);
        out_levels[count++] = level;
        if (access(description, F_OK) == 0) return count;
        char *slash = strrchr(level, '/');
        if (slash && strncmp(slash, "/sub-", 5) == 0) above_subject = count + 1;
        level = slash && slash != level ? strndup(level, (size_t)(slash - level)) : NULL;
    }
    free(level);
    while (count > above_subject) free(out_levels[--count]);
    return count;
}

static json_t *load(struct trk_reading *reading, const char *folder, const char *file,
                    char out_error[TRK_ERROR_SIZE])
{
    char path[PATH_MAX + NAME_MAX + 2];
    struct stat status;
    json_error_t error;
    snprintf(path, sizeof path, "%s/%s", folder, file);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size > MAX_SIDECAR) {
        trk_fail(out_error, "%s: %s, expected a BIDS sidecar of up to 1 MiB", path,
                 fd < 0 ? strerror(errno) : "no regular file, or a longer one");
        if (fd >= 0) close(fd);
        return NULL;
    }
    json_t *root = json_loadfd(fd, 0, &error);
    trk_note_source(reading->log, fd);
    close(fd);
    if (json_is_object(root)) return root;
    trk_fail(out_error, "%s:%d: %.100s, expected a JSON object", path, root ? 1 : error.line,
             root ? "no object" : error.text);
    json_decref(root);
    return NULL;
}

struct candidate {
    char file[NAME_MAX + 1];
    size_t entities;
};

static int by_entities(const void *a, const void *b)
{
    const struct candidate *x = a, *y = b;
    if (x->entities != y->entities) return x->entities > y->entities ? 1 : -1;
    return strcmp(x->file, y->file);
}

/* Merge the keys of the applicable files in one folder into root. Files with more entities come later and
 * override the others. */
static bool take_level(struct trk_reading *reading, const char *folder, const char *suffix, json_t *root,
                       struct trk_bids_places *places, char out_error[TRK_ERROR_SIZE])
{
    enum { MOST = 16 };
    struct candidate found[MOST];
    struct name table, name;
    size_t count = 0;
    DIR *stream = parse_table(&table, reading->lines.path) ? opendir(folder) : NULL;
    if (!stream) return true;
    for (struct dirent *entry; (entry = readdir(stream)) && count < MOST;) {
        if (!parse(&name, entry->d_name, ".json") || !applies(&name, &table, suffix)) continue;
        snprintf(found[count].file, sizeof found[count].file, "%s", entry->d_name);
        found[count++].entities = name.count;
    }
    closedir(stream);
    qsort(found, count, sizeof *found, by_entities);
    for (size_t i = 0; i < count; i++) {
        json_t *object = load(reading, folder, found[i].file, out_error);
        bool ok = object && json_object_update(root, object) == 0;
        json_decref(object);
        if (!ok) return false;
        places->files++;
    }
    return true;
}

json_t *trk_bids_inherit(struct trk_reading *reading, const char *suffix, struct trk_bids_places *out_places,
                         char out_error[TRK_ERROR_SIZE])
{
    char *levels[MAX_LEVELS];
    size_t count = find_levels(reading->lines.path, levels);
    json_t *root = json_object();
    bool ok = root != NULL;
    *out_places = (struct trk_bids_places){.files = 0};
    if (!root) trk_fail(out_error, "%s: no memory", reading->lines.path);
    if (count) snprintf(out_places->top, sizeof out_places->top, "%s", levels[count - 1]);
    for (size_t i = count; i-- > 0;) {
        ok = ok && take_level(reading, levels[i], suffix, root, out_places, out_error);
        free(levels[i]);
    }
    if (ok) return root;
    json_decref(root);
    return NULL;
}
