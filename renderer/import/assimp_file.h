/* What assimp opens files with. */
#ifndef FOVEAD_RENDERER_ASSIMP_FILE_H
#define FOVEAD_RENDERER_ASSIMP_FILE_H

#include "import/import.h"

struct aiFileIO;

/* What assimp opens files with, while in lasts. */
struct aiFileIO rnd_assimp_files(struct rnd_import *in);

#endif
