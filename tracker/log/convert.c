/* The conversion of what devices record to the project's units and frame. */
#include "log/convert.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* --- frames --- */

bool trk_frame_parse(const char *letters, struct trk_frame *out_frame)
{
    static const char ends[3][2] = {{'R', 'L'}, {'U', 'D'}, {'B', 'F'}}; /* plus and minus of each axis */
    int seen = 0;
    if (strlen(letters) != 3) return false;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            for (int end = 0; end < 2; end++) {
                if (letters[i] != ends[k][end] && letters[i] != ends[k][end] + ('a' - 'A')) continue;
                seen |= 1 << k;
                out_frame->axis[k] = i;
                out_frame->sign[k] = end ? -1 : 1;
            }
    return seen == 7;
}

struct trk_frame trk_reading_frame(const struct trk_reading *reading, const char *own)
{
    struct trk_frame frame = {{0, 1, 2}, {1, 1, 1}};
    trk_frame_parse(reading->options->frame ? reading->options->frame : own, &frame);
    return frame;
}

static void turn(const struct trk_frame *frame, const float v[3], float out[3])
{
    float turned[3];
    for (int i = 0; i < 3; i++) turned[i] = frame->sign[i] * v[frame->axis[i]];
    memcpy(out, turned, sizeof turned);
}

bool trk_reading_signs(struct trk_reading *reading, const char *own, double out_signs[2],
                       char out_error[TRK_ERROR_SIZE])
{
    struct trk_frame frame = trk_reading_frame(reading, own);
    if (frame.axis[0] != 0 || frame.axis[1] != 1)
        return trk_lines_fail(
            &reading->lines, out_error,
            "frame '%s' does not go with two numbers a sample, expected L or R, then U or D",
            reading->options->frame);
    for (int i = 0; i < 2; i++) out_signs[i] = frame.sign[i];
    return true;
}

/* --- screens --- */

bool trk_plane_init(struct trk_plane *plane, struct trk_reading *reading, const double size[2], double aspect,
                    double own_fov_deg, const char *what, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_log_options *options = reading->options;
    double half = tan(own_fov_deg * M_PI / 360); /* half the width, in viewing distances */
    if (!trk_reading_signs(reading, "RDF", plane->sign, out_error)) return false;
    if (options->screen_fov_deg > 0)
        half = tan(options->screen_fov_deg * M_PI / 360);
    else if (options->screen_width_m > 0)
        half = options->screen_width_m / 2 / options->screen_distance_m;
    else if (what)
        trk_assume(reading, "%s %.1f degrees wide", what, own_fov_deg);
    plane->middle[0] = size[0] / 2;
    plane->middle[1] = size[1] / 2;
    plane->half[0] = half;
    plane->half[1] = half / aspect;
    for (int i = 0; i < 2; i++) plane->focal[i] = size[i] / 2 / plane->half[i];
    return true;
}

void trk_plane_direction(const struct trk_plane *plane, double x, double y, float out_direction[3])
{
    double v[3] = {plane->sign[0] * (x - plane->middle[0]) / plane->focal[0],
                   plane->sign[1] * (y - plane->middle[1]) / plane->focal[1], -1};
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + 1);
    for (int i = 0; i < 3; i++) out_direction[i] = (float)(v[i] / length);
}

void trk_set_screen(struct trk_sample *sample, const struct trk_plane *screen)
{
    float d[3];
    if (!trk_gaze_direction(sample, d, NULL) || !(d[2] < -1e-6f)) return;
    sample->screen[0] = (float)(0.5 - (double)d[0] / (double)d[2] / screen->half[0] / 2);
    sample->screen[1] = (float)(0.5 + (double)d[1] / (double)d[2] / screen->half[1] / 2);
    sample->valid |= TRK_SCREEN;
}

void trk_angles_direction(double yaw_deg, double pitch_deg, float out_direction[3])
{
    double yaw = yaw_deg * M_PI / 180, pitch = pitch_deg * M_PI / 180;
    out_direction[0] = (float)(cos(pitch) * sin(yaw));
    out_direction[1] = (float)sin(pitch);
    out_direction[2] = (float)(-cos(pitch) * cos(yaw));
}

/* --- samples --- */

static uint32_t bit_of(int eye, uint32_t both, uint32_t left)
{
    return eye == 2 ? both : left << 4 * eye;
}

void trk_set_direction(struct trk_sample *sample, int eye, const float direction[3],
                       const struct trk_frame *frame)
{
    double x = direction[0], y = direction[1], z = direction[2], length = sqrt(x * x + y * y + z * z);
    if (!isfinite(length) || length < 1e-6) return;
    float *out = eye == 2 ? sample->direction : sample->eye[eye].direction;
    float unit[3] = {(float)(x / length), (float)(y / length), (float)(z / length)};
    turn(frame, unit, out);
    sample->valid |= bit_of(eye, TRK_DIRECTION, TRK_LEFT_DIRECTION);
}

void trk_set_origin(struct trk_sample *sample, int eye, const float origin[3], float metres,
                    const struct trk_frame *frame)
{
    float v[3];
    for (int i = 0; i < 3; i++) {
        v[i] = origin[i] * metres;
        if (!(fabsf(v[i]) < 1000)) return; /* an origin a kilometre away is a corrupt number */
    }
    turn(frame, v, eye == 2 ? sample->origin : sample->eye[eye].origin);
    sample->valid |= bit_of(eye, TRK_ORIGIN, TRK_LEFT_ORIGIN);
}

void trk_set_pupil(struct trk_sample *sample, int eye, double mm)
{
    if (!(mm > 0 && mm < 100)) return;
    sample->eye[eye].pupil_mm = (float)mm;
    sample->valid |= TRK_LEFT_PUPIL << 4 * eye;
}

void trk_set_openness(struct trk_sample *sample, int eye, double openness)
{
    if (!isfinite(openness)) return;
    sample->eye[eye].openness = (float)fmin(fmax(openness, 0), 1);
    sample->valid |= TRK_LEFT_OPENNESS << 4 * eye;
}

void trk_unity_euler(const float angles_deg[3], float out_rotation[4])
{
    versor x, y, z, q;
    glm_quatv(x, glm_rad(angles_deg[0]), GLM_XUP);
    glm_quatv(y, glm_rad(angles_deg[1]), GLM_YUP);
    glm_quatv(z, glm_rad(angles_deg[2]), GLM_ZUP);
    glm_quat_mul(y, x, q);
    glm_quat_mul(q, z, q);
    memcpy(out_rotation, q, sizeof q);
}

void trk_set_unity_head(struct trk_sample *sample, const float position[3], const float rotation[4])
{
    versor q = {-rotation[0], -rotation[1], rotation[2], rotation[3]};
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!isfinite(length) || length < 1e-3f) return;
    for (int i = 0; i < 3; i++)
        if (!(fabsf(position[i]) < 1e6f)) return;
    glm_quat_normalize(q);
    glm_vec3_copy((vec3){position[0], position[1], -position[2]}, sample->head);
    memcpy(&sample->head[3], q, sizeof q);
    sample->valid |= TRK_HEAD;
}
