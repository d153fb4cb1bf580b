/* The file that keeps the rotation of recentring, by the XDG Base Directory Specification. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "file.h"
#include "recentring.h"

bool dmn_recentring_path(char *out_path, size_t size)
{
    const char *folder = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    int length = -1;

    /* A relative path in the environment counts as none. */
    if (folder && *folder == '/')
        length = snprintf(out_path, size, "%s/fovead/recentre", folder);
    else if (home && *home == '/')
        length = snprintf(out_path, size, "%s/.local/state/fovead/recentre", home);
    return length > 0 && (size_t)length < size;
}

bool dmn_recentring_load(float out_rotation[4])
{
    char path[4096], error[TRK_ERROR_SIZE];
    struct stat file;

    if (!dmn_recentring_path(path, sizeof(path)) ||
        (stat(path, &file) && (errno == ENOENT || errno == ENOTDIR)))
        return false;
    if (trk_recentre_load(path, out_rotation, error)) return true;
    dmn_print(stderr, "fovead: %s; gaze is not recentred\n", error);
    return false;
}

/* Make the missing folders above path. If that fails, opening the file fails too, and says why. */
static void make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(path, 0700);
        *slash = '/';
    }
}

bool dmn_recentring_save(const float rotation[4], char out_error[TRK_ERROR_SIZE])
{
    char path[4096];
    struct dmn_file file;

    if (!dmn_recentring_path(path, sizeof(path))) {
        snprintf(out_error, TRK_ERROR_SIZE, "neither XDG_STATE_HOME nor HOME names a folder");
        return false;
    }
    make_folders(path);
    if (!dmn_file_begin(&file, path, 0600, true, out_error)) return false;
    trk_recentre_print(rotation, file.file);
    return dmn_file_end(&file, out_error);
}
