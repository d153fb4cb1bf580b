/* The lines of OBJ and MTL files that assimp's materials lack. */
#include "import/mtl_file.h"
#include "import/open_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char blanks[] = " \t\r\n";

/* Split a line into its first word and the rest, without blanks around them. */
static char *split(char *line, char **out_rest)
{
    char *word = line + strspn(line, blanks), *end = word + strcspn(word, blanks);
    char *rest = end + strspn(end, blanks);
    *end = 0;
    for (size_t n = strlen(rest); n > 0 && strchr(blanks, rest[n - 1]); n--) rest[n - 1] = 0;
    *out_rest = rest;
    return word;
}

static bool add_material(struct rnd_mtl_file *file, const char *name)
{
    struct rnd_mtl_material *grown = realloc(file->material, ((size_t)file->count + 1) * sizeof *grown);
    if (!grown) return false;
    file->material = grown;
    struct rnd_mtl_material *m = &grown[file->count];
    *m = (struct rnd_mtl_material){
        .name = strdup(name), .library = file->libraries - 1, .pr = -1.0f, .pm = -1.0f, .bump = 1.0f};
    for (int k = 0; k < RND_MTL_MAPS; k++) m->scale[k][0] = m->scale[k][1] = 1.0f;
    file->count += m->name != NULL;
    return m->name;
}

/* Read up to three numbers after an option, the first two into out. Returns what follows them. */
static char *numbers(char *at, float out[2])
{
    for (int k = 0; k < 3; k++) {
        char *end;
        const float value = strtof(at, &end);
        if (end == at || (*end && !strchr(blanks, *end))) break;
        if (k < 2 && value > -1e6f && value < 1e6f) out[k] = value;
        at = end;
    }
    return at;
}

/* The options of a map: -s u v w, -o u v w, -bm number. */
static void take_options(struct rnd_mtl_material *m, enum rnd_mtl_map map, char *rest)
{
    while (*rest == '-') {
        char *value = rest + strcspn(rest, blanks);
        const size_t length = (size_t)(value - rest);
        float multiplier[2] = {1.0f, 1.0f};
        if (length == 2 && rest[1] == 's')
            rest = numbers(value, m->scale[map]);
        else if (length == 2 && rest[1] == 'o')
            rest = numbers(value, m->offset[map]);
        else if (length == 3 && strncasecmp(rest, "-bm", 3) == 0) {
            rest = numbers(value, multiplier);
            if (map == RND_MTL_NORMAL) m->bump = multiplier[0];
        } else { /* an option that is ignored: skip its numbers, or one word */
            rest = numbers(value, multiplier);
            if (rest == value) rest += strspn(rest, blanks), rest += strcspn(rest, blanks);
        }
        rest += strspn(rest, blanks);
    }
}

static void take_key(struct rnd_mtl_material *m, const char *key, char *rest)
{
    static const struct {
        const char *key;
        enum rnd_mtl_map map;
    } maps[] = {{"map_Kd", RND_MTL_KD},       {"map_Ks", RND_MTL_KS}, {"map_Ke", RND_MTL_KE},
                {"map_emissive", RND_MTL_KE}, {"map_d", RND_MTL_D},   {"norm", RND_MTL_NORMAL},
                {"map_Kn", RND_MTL_NORMAL}};
    if (strcmp(key, "Kd") == 0) m->has_kd = true;
    if (strcmp(key, "Pr") == 0) m->pr = strtof(rest, NULL);
    if (strcmp(key, "Pm") == 0) m->pm = strtof(rest, NULL);
    if (strcasecmp(key, "map_Pr") == 0 || strcasecmp(key, "map_Pm") == 0) m->has_pbr_maps = true;
    for (size_t k = 0; k < sizeof maps / sizeof *maps; k++)
        if (strcasecmp(key, maps[k].key) == 0) take_options(m, maps[k].map, rest);
}

static bool read_library(struct rnd_mtl_file *file, const char *obj, const char *directory, const char *name,
                         struct rnd_scene *scene)
{
    char path[RND_PATH_SIZE], *line = NULL, *rest;
    const char *why;
    size_t room = 0;
    const bool found = rnd_find_file(directory, name, false, path);
    rnd_files_add(&scene->files, path);
    if (!found) { /* assimp has ignored that */
        rnd_warn(&scene->warnings, "%.200s: mtllib %.200s: %s; its materials are left out", obj, name,
                 rnd_why_not_found(path));
        return true;
    }
    FILE *from = rnd_open_file(path, &why);
    void *grown = realloc(file->directory, ((size_t)file->libraries + 1) * sizeof *file->directory);
    bool ok = grown != NULL;
    if (grown) file->directory = grown;
    if (ok && from) {
        char *own = file->directory[file->libraries++], *slash = strrchr(path, '/');
        memcpy(own, path, sizeof path);
        own[slash ? slash + 1 - path : 0] = 0;
    }
    while (ok && from && getline(&line, &room, from) >= 0) {
        const char *key = split(line, &rest);
        if (strcmp(key, "newmtl") == 0)
            ok = add_material(file, rest);
        else if (file->count > 0 && file->material[file->count - 1].library == file->libraries - 1)
            take_key(&file->material[file->count - 1], key, rest);
    }
    free(line);
    if (from) fclose(from);
    return ok;
}

/* --- which libraries an OBJ names --- */

struct mention {
    char *name;
    size_t order; /* in the file */
};

struct mentions {
    struct mention *mention;
    size_t count, room;
};

static int by_name(const void *a, const void *b)
{
    const struct mention *one = a, *other = b;
    const int order = strcmp(one->name, other->name);
    return order != 0 ? order : (one->order > other->order) - (one->order < other->order);
}

static int by_order(const void *a, const void *b)
{
    const struct mention *one = a, *other = b;
    return (one->order > other->order) - (one->order < other->order);
}

static bool mention(struct mentions *all, const char *name)
{
    if (all->count == all->room) {
        const size_t room = 2 * all->room + 16;
        struct mention *grown = realloc(all->mention, room * sizeof *grown);
        if (!grown) return false;
        all->mention = grown;
        all->room = room;
    }
    all->mention[all->count] = (struct mention){strdup(name), all->count};
    return all->mention[all->count].name && ++all->count;
}

static bool find_mentions(struct mentions *all, const char *path)
{
    char *line = NULL, *rest;
    const char *why;
    size_t room = 0;
    bool ok = true;
    FILE *from = rnd_open_file(path, &why);
    while (from && ok && getline(&line, &room, from) >= 0)
        if (strncmp(line + strspn(line, blanks), "mtllib", 6) == 0 &&
            strcmp(split(line, &rest), "mtllib") == 0)
            ok = mention(all, rest);
    free(line);
    if (from) fclose(from);
    return ok;
}

/* Keep the last mention of each library: of materials with the same name the last one counts. */
static void keep_last(struct mentions *all)
{
    size_t kept = 0;
    if (all->count == 0) return;
    qsort(all->mention, all->count, sizeof *all->mention, by_name);
    for (size_t i = 0; i < all->count; i++)
        if (i + 1 < all->count && strcmp(all->mention[i].name, all->mention[i + 1].name) == 0)
            free(all->mention[i].name);
        else
            all->mention[kept++] = all->mention[i];
    all->count = kept;
    qsort(all->mention, all->count, sizeof *all->mention, by_order);
}

bool rnd_mtl_file_read(struct rnd_mtl_file *file, const char *path, const char *directory,
                       struct rnd_scene *scene)
{
    const char *dot = strrchr(path, '.');
    struct mentions all = {0};
    *file = (struct rnd_mtl_file){0};
    if (!dot || strcasecmp(dot, ".obj") != 0) return true;
    bool ok = find_mentions(&all, path);
    keep_last(&all);
    for (size_t i = 0; i < all.count; i++) {
        ok = ok && read_library(file, path, directory, all.mention[i].name, scene);
        free(all.mention[i].name);
    }
    free(all.mention);
    return ok;
}

void rnd_mtl_file_finish(struct rnd_mtl_file *file)
{
    for (int i = 0; i < file->count; i++) free(file->material[i].name);
    free(file->material);
    free(file->directory);
}

const struct rnd_mtl_material *rnd_mtl_file_find(const struct rnd_mtl_file *file, const char *name)
{
    for (int i = file->count; i > 0; i--)
        if (strcmp(file->material[i - 1].name, name) == 0) return &file->material[i - 1];
    return NULL;
}
