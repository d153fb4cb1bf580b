/* Files as assimp gets them: only regular ones; and material libraries without the lines above the first
 * material, which assimp 5.2.5 and 5.4.3 would write to a null pointer. */
#include "import/assimp_file.h"
#include "import/open_file.h"

#include <assimp/cfileio.h>

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <unistd.h>

static FILE *file_of(struct aiFile *file)
{
    return (FILE *)(void *)file->UserData;
}

static size_t read_some(struct aiFile *file, char *out, size_t size, size_t count)
{
    return fread(out, size, count, file_of(file));
}

static size_t write_nothing(struct aiFile *file, const char *bytes, size_t size, size_t count)
{
    (void)file, (void)bytes, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    return (size_t)ftell(file_of(file));
}

static size_t size_of(struct aiFile *file)
{
    FILE *from = file_of(file);
    const long at = ftell(from), end = fseek(from, 0, SEEK_END) == 0 ? ftell(from) : 0;
    return fseek(from, at, SEEK_SET) == 0 && end > 0 ? (size_t)end : 0;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin from)
{
    const int whence = from == aiOrigin_SET ? SEEK_SET : from == aiOrigin_CUR ? SEEK_CUR : SEEK_END;
    return fseek(file_of(file), (long)offset, whence) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
}

static void flush_nothing(struct aiFile *file)
{
    (void)file;
}

/* --- material libraries --- */

static bool ends_in_mtl(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, ".mtl") == 0;
}

/* A copy of a material library without the lines above its first material, with a warning. NULL if it cannot
 * be made. */
static FILE *from_first_material(struct rnd_import *in, const char *path, FILE *from)
{
    char *line = NULL;
    size_t room = 0;
    bool begun = false, ok = true;
    const int memory = memfd_create("mtl", MFD_CLOEXEC);
    FILE *to = memory >= 0 ? fdopen(memory, "w+") : NULL;
    if (memory >= 0 && !to) close(memory);
    ssize_t length;
    for (int number = 1; to && ok && (length = getline(&line, &room, from)) >= 0; number++) {
        const char *word = line + strspn(line, " \t\r\n");
        begun = begun || strncmp(word, "newmtl", 6) == 0;
        if (begun)
            ok = fwrite(line, 1, (size_t)length, to) == (size_t)length; /* the line may hold NULs */
        else if (*word && *word != '#')
            rnd_warn(&in->scene->warnings,
                     "%.200s: line %d: %.*s: expected newmtl before it; it is passed over", path, number,
                     (int)strcspn(word, " \t\r\n"), word);
    }
    free(line);
    if (to && ok && fflush(to) == 0 && fseek(to, 0, SEEK_SET) == 0) return to;
    if (to) fclose(to);
    return NULL;
}

/* --- all --- */

static struct aiFile *open_one(struct aiFileIO *files, const char *path, const char *mode)
{
    struct rnd_import *in = (struct rnd_import *)(void *)files->UserData;
    const char *why;
    if (strpbrk(mode, "wa+")) return NULL;
    rnd_files_add(&in->scene->files, path);
    FILE *from = rnd_open_file(path, &why);
    if (from && ends_in_mtl(path)) {
        FILE *cleaned = from_first_material(in, path, from);
        fclose(from);
        from = cleaned;
    }
    struct aiFile *file = from ? malloc(sizeof *file) : NULL;
    if (file)
        *file = (struct aiFile){.ReadProc = read_some,
                                .WriteProc = write_nothing,
                                .TellProc = tell,
                                .FileSizeProc = size_of,
                                .SeekProc = seek,
                                .FlushProc = flush_nothing,
                                .UserData = (aiUserData)(void *)from};
    else if (from)
        fclose(from);
    return file;
}

static void close_one(struct aiFileIO *files, struct aiFile *file)
{
    (void)files;
    fclose(file_of(file));
    free(file);
}

struct aiFileIO rnd_assimp_files(struct rnd_import *in)
{
    return (struct aiFileIO){
        .OpenProc = open_one, .CloseProc = close_one, .UserData = (aiUserData)(void *)in};
}
