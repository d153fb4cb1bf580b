/* fovead-reader: reads a scene file for a program that does not trust it. Nobody types its name:
 *
 *   fovead-reader PARENT MIB SECONDS FILE
 *
 * The scene goes to descriptor 3 (flat.h), or, with exit code 1, a line of what is wrong with the file.
 * Descriptor 4 is there to be closed. */
#include "import/flat_put.h"
#include "import/formats.h"
#include "import/reader.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SCENE = 3 };

int main(int count, char **argument)
{
    static struct rnd_scene scene;
    char error[RND_ERROR_SIZE] = "";
    if (count != 5) return RND_READER_REFUSES;
    rnd_reader_begin((pid_t)strtol(argument[1], NULL, 10), (uint32_t)strtoul(argument[2], NULL, 10));
    rnd_reader_limit_time((uint32_t)strtoul(argument[3], NULL, 10));
    const bool ok = rnd_import(&scene, argument[4], error);
    const bool short_of_memory = strstr(error, "not enough memory") || strstr(error, "bad_alloc");
    if (ok ? !rnd_flat_put(&scene, SCENE) : short_of_memory) _exit(RND_READER_MEMORY);
    if (!ok && write(SCENE, error, strlen(error)) < 0) _exit(RND_READER_MEMORY);
    _exit(ok ? 0 : RND_READER_REFUSES); /* without freeing memory, which is faster */
}
