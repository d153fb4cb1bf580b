/* own: the project's own format of gaze logs. It is text that a person can read and any tool can split.
 *
 * - Line 1 is "fovead-gaze 1".
 * - Line 2 has the names of the columns below, separated by one space: 33, or 35 for a tracker with a screen.
 * - Each further line is one sample, with a number for each column, separated by one space. Lines that start
 *   with # are comments.
 *
 * The columns:
 * - sequence: counts the tracker's samples from 1; a gap means lost samples.
 * - device[ns], arrival[ns]: the tracker's clock, which starts at 0; the clock of the recording host.
 * - valid[bits]: which fields are valid, the sum of: 1 direction, 2 origin, 4 head pose, 8 screen; for the
 *   left eye 16 direction, 32 origin, 64 openness, 128 pupil; for the right eye 256, 512, 1024, 2048.
 * - direction_{x,y,z}[head]: combined gaze direction, unit length.
 * - origin_{x,y,z}[head,m]: combined gaze origin.
 * - left_direction_..., left_origin_...: direction and origin of the left eye; then left_openness[0..1] (0
 *   closed) and left_pupil[mm], the diameter of its pupil. Then the same for the right eye: right_...
 * - head_{x,y,z}[world,m], head_q{x,y,z,w}[head-to-world]: head pose, position and unit quaternion.
 * - screen_{x,y}[0..1]: the point on the screen, from its top left corner, as fractions of its size.
 *
 * Frames are right-handed: +X right, +Y up, -Z forward. Times are whole nanoseconds and never go back.
 * Numbers are decimal and read back exactly. A field whose bit is unset is written as 0. The last line ends
 * with a newline. A last line without a newline was cut off: it is dropped, and trk_log.assumed says so.
 * Lines may end with CRLF. */
#ifndef FOVEAD_TRACKER_LOG_OWN_H
#define FOVEAD_TRACKER_LOG_OWN_H

#include "tracker.h"

/* Bytes for the first two lines of a file, or for the line of one sample. */
enum { TRK_OWN_SIZE = 4096 };

/* Write the first two lines of a file, or the line of one sample. Both return the length. */
size_t trk_own_header(bool with_screen, char out_text[TRK_OWN_SIZE]);
size_t trk_own_row(const struct trk_sample *sample, bool with_screen, char out_text[TRK_OWN_SIZE]);
/* Would trk_log_read() accept the sample's row? Valid fields must be finite, and valid directions and
 * rotations must have unit length. */
bool trk_own_accepts(const struct trk_sample *sample);

#endif
