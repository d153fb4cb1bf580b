/* Reading a glTF file: its parts, in order. */
#include "import/gltf.h"
#include "import/gltf_json.h"
#include "import/gltf_material.h"
#include "import/gltf_node.h"

bool rnd_import_gltf(struct rnd_import *in)
{
    struct rnd_gltf gltf;
    in->most = RND_LEAST_TRIANGLES;
    const bool ok = rnd_gltf_open(&gltf, in) && rnd_gltf_check_nodes(&gltf) && rnd_gltf_first_frame(&gltf) &&
                    rnd_gltf_materials(&gltf) && rnd_import_nodes(in, rnd_gltf_walk, &gltf);
    if (ok) rnd_gltf_name_unsupported(&gltf);
    rnd_gltf_close(&gltf);
    return ok;
}
