/* The camera: where a picture is rendered from. */
#ifndef FOVEAD_RENDERER_CAMERA_H
#define FOVEAD_RENDERER_CAMERA_H

struct rnd_camera {
    float position[3]; /* m, in the scene's own coordinates */
    double origin[3];  /* where these begin, in the world (m) */
};

/* position: in the world (m). */
static inline struct rnd_camera rnd_camera_at(const double position[3], const double origin[3])
{
    struct rnd_camera camera;
    for (int k = 0; k < 3; k++) {
        camera.position[k] = (float)(position[k] - origin[k]);
        camera.origin[k] = origin[k];
    }
    return camera;
}

#endif
