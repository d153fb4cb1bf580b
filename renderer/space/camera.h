/* Where a picture is rendered from. */
#ifndef FOVEAD_RENDERER_CAMERA_H
#define FOVEAD_RENDERER_CAMERA_H

struct rnd_camera {
    float position[3]; /* m, in the scene's own coordinates */
};

#endif
