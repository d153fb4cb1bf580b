/* Nodes of a glTF file: where the scene begins, and the first frame of its animation. */
#ifndef FOVEAD_RENDERER_GLTF_NODE_H
#define FOVEAD_RENDERER_GLTF_NODE_H

#include "import/gltf_document.h"

/* Check that the nodes are trees, and find the roots of the scene. False and a line. */
bool rnd_gltf_check_nodes(struct rnd_gltf *gltf);
/* Read the poses of the first frame of the animation, and whether it morphs. False and a line. */
bool rnd_gltf_first_frame(struct rnd_gltf *gltf);
/* Hand over all nodes of the scene; rnd_import_nodes() calls this. */
bool rnd_gltf_walk(struct rnd_import *in, void *gltf);

#endif
