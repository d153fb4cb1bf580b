/* convert: turns what devices record into our units and frame: frames, screens, and the fields of a sample.
 */
#ifndef FOVEAD_TRACKER_LOG_CONVERT_H
#define FOVEAD_TRACKER_LOG_CONVERT_H

#include "log/reading.h"

/* How a file's vectors turn into ours (+X right, +Y up, -Z forward): three letters say where its +X, +Y and
 * +Z point, L left or R right, U up or D down, F forward or B back. */
struct trk_frame {
    int axis[3]; /* of the file's vector, for each of ours */
    float sign[3];
};
bool trk_frame_parse(const char *letters, struct trk_frame *out_frame);

/* The frame that the options name, else the format's own, which must be valid. */
struct trk_frame trk_reading_frame(const struct trk_reading *reading, const char *own);

/* Signs of x to the right and y upwards for formats with two numbers and no vectors; false with a message if
 * the options name a frame whose +X and +Y are not horizontal and vertical. */
bool trk_reading_signs(struct trk_reading *reading, const char *own, double out_signs[2],
                       char out_error[TRK_ERROR_SIZE]);

/* A flat screen, or a camera's picture, straight ahead: direction = ((x - middle) / focal, ..., -1). */
struct trk_plane {
    double middle[2], focal[2]; /* both in the unit of x and y */
    double sign[2];             /* 1 where x grows to the right, y upwards */
};

/* Its geometry from the options; else it is own_fov_deg wide, which is noted (not if what is NULL). size is
 * its width and height in the unit of x and y; aspect is the true width by height. */
bool trk_plane_init(struct trk_plane *plane, struct trk_reading *reading, const double size[2], double aspect,
                    double own_fov_deg, const char *what, char out_error[TRK_ERROR_SIZE]);
void trk_plane_direction(const struct trk_plane *plane, double x, double y, float out_direction[3]);

/* 0.52 m of screen at 0.65 m, for logs that do not know their screen. */
#define TRK_SCREEN_FOV_DEG 43.6028

/* A direction from yaw to the right and pitch upwards, degrees. */
void trk_angles_direction(double yaw_deg, double pitch_deg, float out_direction[3]);

/* An eye's direction (eye 0 left, 1 right, 2 both together), turned from the file's frame and made unit. Not
 * finite or shorter than 1e-6: lost, nothing is set. */
void trk_set_direction(struct trk_sample *sample, int eye, const float direction[3],
                       const struct trk_frame *frame);

/* An eye's origin, the same way, scaled to metres; lost if not finite. */
void trk_set_origin(struct trk_sample *sample, int eye, const float origin[3], float metres,
                    const struct trk_frame *frame);

/* Pupil in mm (not finite or not above 0: unknown) and openness 0..1 (not finite: unknown) of eye 0 or 1. */
void trk_set_pupil(struct trk_sample *sample, int eye, double mm);
void trk_set_openness(struct trk_sample *sample, int eye, double openness);

/* Unity's frame is left-handed, +X right, +Y up, +Z forward, in metres; mirroring Z takes it to ours. Its
 * Euler angles are degrees, applied about Z, then X, then Y. Numbers that are not finite leave the pose
 * unset. */
void trk_set_unity_head(struct trk_sample *sample, const float position[3], const float rotation[4]);
void trk_unity_euler(const float angles_deg[3], float out_rotation[4]);

#endif
