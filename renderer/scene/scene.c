/* What the readers of scene files use too: memory of meshes, warnings for the user. */
#include "scene/scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void rnd_warn(struct rnd_warnings *warnings, const char *format, ...)
{
    enum { MOST_LINES = 20 };
    char line[2 * RND_ERROR_SIZE];
    va_list arguments;
    va_start(arguments, format);
    const int wanted = vsnprintf(line, sizeof line - 1, format, arguments);
    va_end(arguments);
    if (wanted < 0 || warnings->lines > MOST_LINES) return;
    rnd_make_printable(line);
    if (warnings->lines == MOST_LINES) strcpy(line, "and more of the kind");
    strcat(line, "\n");
    if (warnings->text && strstr(warnings->text, line)) return;
    const size_t length = strlen(line);
    char *grown = realloc(warnings->text, warnings->size + length + 1);
    if (!grown) return;
    memcpy(grown + warnings->size, line, length + 1);
    warnings->text = grown;
    warnings->size += length;
    warnings->lines++;
}

void rnd_scene_unsupported(struct rnd_scene *scene, const char *name)
{
    const size_t used = strlen(scene->unsupported);
    if (strstr(scene->unsupported, name)) return;
    if (used + strlen(name) + 3 > sizeof scene->unsupported) return;
    snprintf(scene->unsupported + used, sizeof scene->unsupported - used, "%s%s", used ? ", " : "", name);
    rnd_make_printable(scene->unsupported + used);
}

void rnd_mesh_finish(struct rnd_mesh *mesh)
{
    free(mesh->position);
    free(mesh->normal);
    free(mesh->uv[0]);
    free(mesh->uv[1]);
    free(mesh->colour);
    free(mesh->tangent);
    free(mesh->index);
}
