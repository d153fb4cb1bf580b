/* Edits of the scene's files: inotify reports them, and the scene is read once they have settled. */
#include <dirent.h>
#include <errno.h>
#include <libgen.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "edits.h"
#include "report.h"

enum {
    SETTLE_MS = 100,    /* without a further change, before edits are taken up */
    PATIENCE_MS = 2000, /* the longest wait after the first change */
    RETRY_MS = 1000,    /* between two searches for a folder that has gone */
    MOST_NAMES = 64,    /* of changed files at a time; with more of them, any file counts as changed */
    MOST_FOLDERS = 256,
    NAME_SIZE = 256,
};

static const uint32_t EVENTS =
    IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;

struct dmn_edits {
    struct rnd_scene_options scene;
    struct dmn_edits_options options;
    char folder[4096], name[NAME_SIZE];         /* of the scene */
    char env_folder[4096], env_name[NAME_SIZE]; /* of its environment map; "": none */
    int inotify, stop;
    int watch, env_watch; /* of the two folders; -1: gone */
    pthread_t thread;
    bool started;
    atomic_bool
        stopped; /* set under the lock: ignore edits, abandon a scene that is being read, and wake nobody */

    char *files; /* files that the scene in use names: files_bytes bytes of paths, each with its NUL */
    size_t files_bytes;

    /* What has changed since the last time. */
    bool dirty;                          /* the scene is known to have changed */
    char changed[MOST_NAMES][NAME_SIZE]; /* files that may be the scene's */
    int count;

    pthread_mutex_t lock; /* of all that follows */
    struct dmn_scene_words words;
    bool news;
};

/* --- which changes count --- */

static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');

    return slash ? slash + 1 : path;
}

/* Has one of the changed files a name that the scene uses? Letter case is ignored, as it is when the scene's
 * files are looked for. */
static bool names_one(const struct dmn_edits *edits)
{
    for (size_t at = 0; at < edits->files_bytes; at += strlen(edits->files + at) + 1)
        for (int i = 0; i < edits->count; i++)
            if (!strcasecmp(base_of(edits->files + at), edits->changed[i])) return true;
    return false;
}

/* After an edit that could not be read it is not known which files the scene names: a missing one may have
 * come. */
static bool concerns_scene(const struct dmn_edits *edits)
{
    return edits->dirty || (edits->count > 0 && (*edits->words.refused || names_one(edits)));
}

/* Remember which files a scene names. False if memory is short. */
static bool keep_files(struct dmn_edits *edits, const struct rnd_scene_info *info)
{
    char *files = malloc(info->files_bytes + 1);

    if (!files) return false;
    memcpy(files, info->files, info->files_bytes);
    free(edits->files);
    edits->files = files;
    edits->files_bytes = info->files_bytes;
    return true;
}

/* --- what changes --- */

/* Watch the folders in the scene's folder, where textures often are. A folder that cannot be watched is left
 * out. */
static void watch_within(const struct dmn_edits *edits)
{
    DIR *folder = opendir(edits->folder);
    struct dirent *entry;
    int count = 0;

    while (folder && count < MOST_FOLDERS && (entry = readdir(folder))) {
        char path[4096 + NAME_SIZE];

        if (entry->d_name[0] == '.' || entry->d_type == DT_REG) continue;
        snprintf(path, sizeof(path), "%s/%s", edits->folder, entry->d_name);
        count += inotify_add_watch(edits->inotify, path, EVENTS) >= 0;
    }
    if (folder) closedir(folder);
}

/* Is a folder missing that should be watched? */
static bool has_lost(const struct dmn_edits *edits)
{
    return edits->watch < 0 || (edits->env_watch < 0 && *edits->env_name);
}

/* True if all are there now. */
static bool watch_folders(struct dmn_edits *edits)
{
    if (edits->watch < 0) {
        edits->watch = inotify_add_watch(edits->inotify, edits->folder, EVENTS);
        if (edits->watch >= 0) watch_within(edits);
    }
    if (edits->env_watch < 0 && *edits->env_name)
        edits->env_watch = inotify_add_watch(edits->inotify, edits->env_folder, EVENTS);
    return !has_lost(edits);
}

static void note(struct dmn_edits *edits, const struct inotify_event *event)
{
    bool is_folder = event->mask & IN_ISDIR,
         within = event->wd != edits->watch && event->wd != edits->env_watch;

    if (event->mask & IN_Q_OVERFLOW) edits->dirty = true;
    if (event->mask & IN_MOVE_SELF) inotify_rm_watch(edits->inotify, event->wd);
    if (event->mask & IN_IGNORED) {
        if (event->wd == edits->watch) edits->watch = -1;
        if (event->wd == edits->env_watch) edits->env_watch = -1;
    }
    if (!event->len || strlen(event->name) >= NAME_SIZE) return;
    if (!is_folder && !(event->mask & (IN_CLOSE_WRITE | IN_MOVED_TO))) return; /* the file is still empty */
    if (is_folder && event->wd == edits->watch) watch_within(edits);
    if (event->wd == edits->watch && !strcmp(event->name, edits->name)) edits->dirty = true;
    if (event->wd == edits->env_watch && !strcmp(event->name, edits->env_name)) edits->dirty = true;
    if (event->wd != edits->watch && !within) return;
    for (int i = 0; i < edits->count; i++)
        if (!strcmp(edits->changed[i], event->name)) return;
    if (edits->count == MOST_NAMES)
        edits->dirty = true;
    else
        strcpy(edits->changed[edits->count++], event->name);
}

static void read_events(struct dmn_edits *edits)
{
    _Alignas(struct inotify_event) char bytes[16384];
    ssize_t count;

    while ((count = read(edits->inotify, bytes, sizeof(bytes))) > 0)
        for (ssize_t at = 0; at < count;) {
            const struct inotify_event *event = (const struct inotify_event *)(const void *)(bytes + at);

            note(edits, event);
            at += (ssize_t)(sizeof(*event) + event->len);
        }
}

/* Wait for changes. Returns -1 if the thread must stop, 0 after timeout_ms. */
static int wait_for(struct dmn_edits *edits, int timeout_ms)
{
    struct pollfd wait[2] = {{.fd = edits->stop, .events = POLLIN}, {.fd = edits->inotify, .events = POLLIN}};

    if (poll(wait, 2, timeout_ms) < 0 && errno != EINTR) return -1;
    if (wait[0].revents) return -1;
    if (!wait[1].revents) return 0;
    read_events(edits);
    return 1;
}

/* --- taking them up --- */

static void tell(struct dmn_edits *edits, const char *line_or_null, const char *refused)
{
    pthread_mutex_lock(&edits->lock);
    if (line_or_null) snprintf(edits->words.line, sizeof(edits->words.line), "%s", line_or_null);
    snprintf(edits->words.refused, sizeof(edits->words.refused), "%s", refused);
    edits->news = true;
    if (!edits->stopped) edits->options.wake(edits->options.context);
    pthread_mutex_unlock(&edits->lock);
}

/* If another file has changed and the scene is broken as before, this is not said again. */
static void refuse(struct dmn_edits *edits, const char *error)
{
    if (!edits->dirty && !strcmp(error, edits->words.refused)) return;
    dmn_print(stderr, "fovead: the edit is not taken, the picture stays: %s\n", error);
    tell(edits, NULL, error);
}

static void take_up(struct dmn_edits *edits)
{
    struct rnd_scene_options options = edits->scene;
    struct rnd_scene *scene, *former;
    char error[RND_ERROR_SIZE], line[sizeof(edits->words.line)];
    double camera[3];

    if (dmn_painter_moved(edits->options.painter, camera)) {
        options.has_camera = true;
        memcpy(options.camera, camera, sizeof(options.camera));
    }
    options.cancel = &edits->stopped;
    scene = rnd_scene_load(&options, error);
    if (!scene && edits->stopped) return;
    if (!scene) {
        refuse(edits, error);
        return;
    }
    dmn_report_scene(rnd_scene_info(scene), options.path, line, sizeof(line));
    former = dmn_painter_replace(edits->options.painter, scene);
    if (former != scene) {
        *edits->options.scene = scene;
        keep_files(edits, rnd_scene_info(scene));
        dmn_print(edits->options.out, "scene    %s\n", line);
        fflush(edits->options.out);
        dmn_report_left_out(rnd_scene_info(scene), options.path);
        tell(edits, line, "");
    }
    rnd_scene_destroy(former);
}

static void *run(void *argument)
{
    struct dmn_edits *edits = argument;
    int came;

    while ((came = wait_for(edits, has_lost(edits) ? RETRY_MS : -1)) >= 0) {
        uint64_t end_ns = dmn_now_ns() + (uint64_t)PATIENCE_MS * 1000000;

        if (has_lost(edits) && watch_folders(edits)) edits->dirty = true;
        if (!edits->dirty && !edits->count) continue;
        do came = wait_for(edits, SETTLE_MS);
        while (came > 0 && dmn_now_ns() < end_ns);
        if (came < 0) break;
        if (concerns_scene(edits)) take_up(edits);
        edits->dirty = false;
        edits->count = 0;
    }
    return NULL;
}

/* --- life --- */

static void split(const char *path, char *out_folder, size_t size, char *out_name)
{
    char copy[4096];

    snprintf(copy, sizeof(copy), "%s", path);
    snprintf(out_folder, size, "%s", dirname(copy));
    snprintf(copy, sizeof(copy), "%s", path);
    snprintf(out_name, NAME_SIZE, "%s", basename(copy));
}

struct dmn_edits *dmn_edits_create(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE])
{
    struct dmn_edits *edits = calloc(1, sizeof(*edits));

    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be watched", options->path);
    if (!edits) return NULL;
    edits->scene = *options;
    edits->watch = edits->env_watch = -1;
    pthread_mutex_init(&edits->lock, NULL);
    split(options->path, edits->folder, sizeof(edits->folder), edits->name);
    if (options->env_path)
        split(options->env_path, edits->env_folder, sizeof(edits->env_folder), edits->env_name);
    edits->inotify = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    edits->stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (edits->inotify >= 0 && edits->stop >= 0 && watch_folders(edits)) return edits;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be watched: %s", options->path, strerror(errno));
    dmn_edits_destroy(edits);
    return NULL;
}

bool dmn_edits_start(struct dmn_edits *edits, const struct dmn_edits_options *options)
{
    edits->options = *options;
    edits->words = *options->words;
    if (!keep_files(edits, rnd_scene_info(*options->scene))) return false;
    return edits->started = !pthread_create(&edits->thread, NULL, run, edits);
}

void dmn_edits_words(struct dmn_edits *edits, struct dmn_scene_words *words)
{
    pthread_mutex_lock(&edits->lock);
    if (edits->news) *words = edits->words;
    edits->news = false;
    pthread_mutex_unlock(&edits->lock);
}

void dmn_edits_stop(struct dmn_edits *edits)
{
    if (!edits) return;
    pthread_mutex_lock(&edits->lock);
    edits->stopped = true;
    pthread_mutex_unlock(&edits->lock);
    eventfd_write(edits->stop, 1);
}

void dmn_edits_destroy(struct dmn_edits *edits)
{
    if (!edits) return;
    dmn_edits_stop(edits);
    if (edits->started) pthread_join(edits->thread, NULL);
    if (edits->inotify >= 0) close(edits->inotify);
    if (edits->stop >= 0) close(edits->stop);
    pthread_mutex_destroy(&edits->lock);
    free(edits->files);
    free(edits);
}
