/* What assimp does not tell of an OBJ file's material libraries: which keys a material has, where its file
 * is, and how its maps are scaled and moved. */
#ifndef FOVEAD_RENDERER_MTL_FILE_H
#define FOVEAD_RENDERER_MTL_FILE_H

#include "import/find_file.h"
#include "scene/scene.h"

/* Maps whose options are kept. */
enum rnd_mtl_map { RND_MTL_KD, RND_MTL_KS, RND_MTL_KE, RND_MTL_D, RND_MTL_NORMAL, RND_MTL_MAPS };

struct rnd_mtl_material {
    char *name;
    int library;                                           /* index of the file that it is in */
    bool has_kd;                                           /* else assimp assumes 0.6 */
    float pr, pm;                                          /* roughness and metalness; negative: not given */
    bool has_pbr_maps;                                     /* map_Pr or map_Pm */
    float bump;                                            /* of the normal map: -bm; 1 */
    float scale[RND_MTL_MAPS][2], offset[RND_MTL_MAPS][2]; /* -s and -o; 1 and 0 */
};

struct rnd_mtl_file {
    int libraries, count;
    char (*directory)[RND_PATH_SIZE]; /* of each library, with its slash, or "" */
    struct rnd_mtl_material *material;
};

/* Read the libraries that an OBJ file names, and add their paths to the scene's files; a library that cannot
 * be read is a warning. Files of other formats have none. False if memory is short. */
bool rnd_mtl_file_read(struct rnd_mtl_file *file, const char *path, const char *directory,
                       struct rnd_scene *scene);
void rnd_mtl_file_finish(struct rnd_mtl_file *file);

/* The last material of that name, which is the one that assimp uses; NULL if there is none. */
const struct rnd_mtl_material *rnd_mtl_file_find(const struct rnd_mtl_file *file, const char *name);

#endif
