/* Chooses the reader of a scene file. */
#include "import/formats.h"
#include "import/assimp.h"
#include "import/gltf.h"
#include "import/import.h"
#include "import/open_file.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Is the file glTF, by the end of its name or the first bytes of a GLB? */
static bool is_gltf(const char *path, const char start[4])
{
    const char *dot = strrchr(path, '.');
    return memcmp(start, "glTF", 4) == 0 ||
           (dot && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0));
}

bool rnd_import(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct rnd_import in = {.scene = scene, .path = path, .error = out_error};
    char start[4] = {0};
    const char *slash = strrchr(path, '/');
    if (slash && snprintf(in.directory, sizeof in.directory, "%.*s", (int)(slash - path + 1), path) >=
                     (int)sizeof in.directory)
        return rnd_import_fail(&in, "the path is too long");

    const char *why;
    FILE *file = rnd_open_file(path, &why); /* assimp does not say why it cannot open a file */
    if (!file) return rnd_import_fail(&in, "%s", why);
    const size_t count = fread(start, 1, sizeof start, file);
    fclose(file);
    if (count == 0) return rnd_import_fail(&in, "is empty");
    const bool ok = is_gltf(path, start) ? rnd_import_gltf(&in) : rnd_import_assimp(&in);
    rnd_import_finish(&in);
    return ok;
}
