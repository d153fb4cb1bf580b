/* convert: turns what devices record into the project's units and frame: frames, screens, and the fields of a
 * sample. */
#ifndef FOVEAD_TRACKER_LOG_CONVERT_H
#define FOVEAD_TRACKER_LOG_CONVERT_H

#include "log/reading.h"

/* How to turn a file's vectors into the project's frame (+X right, +Y up, -Z forward). Three letters say
 * where the file's +X, +Y and +Z point: L left or R right, U up or D down, F forward or B back. */
struct trk_frame {
    int axis[3]; /* the component of the file's vector that each axis takes */
    float sign[3];
};
bool trk_frame_parse(const char *letters, struct trk_frame *out_frame);

/* The frame from the options, else the format's own, which must be valid. */
struct trk_frame trk_reading_frame(const struct trk_reading *reading, const char *own);

/* The signs that turn x to the right and y upwards, for formats that give two numbers instead of vectors.
 * False with a message if the options give a frame whose +X is not horizontal or whose +Y is not vertical. */
bool trk_reading_signs(struct trk_reading *reading, const char *own, double out_signs[2],
                       char out_error[TRK_ERROR_SIZE]);

/* A flat screen, or a camera's picture, straight ahead. The direction of a point is ((x - middle) / focal,
 * ..., -1). */
struct trk_plane {
    double middle[2], focal[2]; /* both in the unit of x and y */
    double sign[2];             /* 1 if x grows to the right, and if y grows upwards */
    double half[2];             /* half its width and height, in viewing distances */
};

/* Set up a plane. Its geometry comes from the options; without them it is own_fov_deg wide, and a note says
 * so unless `what` is NULL. size is the plane's width and height in the unit of x and y; aspect is the true
 * width divided by the true height. */
bool trk_plane_init(struct trk_plane *plane, struct trk_reading *reading, const double size[2], double aspect,
                    double own_fov_deg, const char *what, char out_error[TRK_ERROR_SIZE]);
void trk_plane_direction(const struct trk_plane *plane, double x, double y, float out_direction[3]);

/* Set the point on the screen that the sample's gaze meets, once the gaze is complete. A sample without gaze
 * gets none. Of the screen only half is used: it is straight ahead, as in trk_plane_direction(). */
void trk_set_screen(struct trk_sample *sample, const struct trk_plane *screen);

/* A screen 0.52 m wide at 0.65 m, for logs that do not describe their screen. */
#define TRK_SCREEN_FOV_DEG 43.6028

/* The direction at a yaw to the right and then a pitch upwards, both in degrees. */
void trk_angles_direction(double yaw_deg, double pitch_deg, float out_direction[3]);

/* Set the direction of an eye (0 left, 1 right, 2 both together): turn it from the file's frame and normalise
 * it. A direction that is not finite or is shorter than 1e-6 counts as lost; nothing is set. */
void trk_set_direction(struct trk_sample *sample, int eye, const float direction[3],
                       const struct trk_frame *frame);

/* Set the origin of an eye: turn it from the file's frame and scale it to metres. Nothing is set if it is not
 * finite or is a kilometre or more away. */
void trk_set_origin(struct trk_sample *sample, int eye, const float origin[3], float metres,
                    const struct trk_frame *frame);

/* Set the pupil in mm and the openness 0..1 of eye 0 or 1. Nothing is set if the number is not finite, or if
 * the pupil is not between 0 and 100 mm. */
void trk_set_pupil(struct trk_sample *sample, int eye, double mm);
void trk_set_openness(struct trk_sample *sample, int eye, double openness);

/* Unity's frame is left-handed, +X right, +Y up, +Z forward, in metres; mirroring Z turns it into the
 * project's frame. Unity's Euler angles are degrees, applied about Z, then X, then Y. If a number is not
 * finite, the pose is not set. */
void trk_set_unity_head(struct trk_sample *sample, const float position[3], const float rotation[4]);
void trk_unity_euler(const float angles_deg[3], float out_rotation[4]);

#endif
