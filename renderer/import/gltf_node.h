/* Nodes of a glTF file: where the scene begins, and the first frame of its animation. */
#ifndef FOVEAD_RENDERER_GLTF_NODE_H
#define FOVEAD_RENDERER_GLTF_NODE_H

#include "import/gltf_document.h"

/* See that nodes are trees, and find where the scene begins. False and a line. */
bool rnd_gltf_check_nodes(struct rnd_gltf *gltf);
/* Find the poses of the first frame, and whether it is morphed. False and a line. */
bool rnd_gltf_first_frame(struct rnd_gltf *gltf);
/* Hand all nodes of the scene over: rnd_import_nodes() calls it. */
bool rnd_gltf_walk(struct rnd_import *in, void *gltf);

#endif
