/* own: the project's own format of gaze logs, text that a person can read and any tool can split.
 *
 * - Line 1 is "fovead-gaze 1".
 * - Line 2 has the names of the 33 columns below, separated by one space; of 35, with a screen.
 * - Then one sample a line: as many numbers, separated by one space. Lines that start with # are comments.
 *
 * The columns:
 * - sequence: counts the tracker's samples from 1; a gap is a lost sample.
 * - device[ns], arrival[ns]: the tracker's clock from 0; the recording host's clock.
 * - valid[bits]: which fields are valid: the sum of 1 direction, 2 origin, 4 head pose, 8 screen; of the
 *   left eye 16 direction, 32 origin, 64 openness, 128 pupil; of the right eye 256, 512, 1024, 2048.
 * - direction_{x,y,z}[head]: combined gaze direction, unit length.
 * - origin_{x,y,z}[head,m]: combined gaze origin.
 * - left_direction_..., left_origin_...: the same of the left eye; then left_openness[0..1] (0 closed) and
 *   left_pupil[mm], its diameter. Then right_...
 * - head_{x,y,z}[world,m], head_q{x,y,z,w}[head-to-world]: head pose, position and unit quaternion.
 * - screen_{x,y}[0..1]: the point on the screen, from its top left corner, as shares of its size.
 *
 * Frames are right-handed: +X right, +Y up, -Z forward. Times are whole nanoseconds and never go back.
 * Numbers are decimal and read back exactly. A field whose bit is unset is written as 0. The last line ends
 * with a newline; one that does not was cut off, and is left out, which trk_log.assumed says. Lines may end
 * with CRLF. */
#ifndef FOVEAD_TRACKER_LOG_OWN_H
#define FOVEAD_TRACKER_LOG_OWN_H

#include "tracker.h"

/* Room for the first two lines, and for the line of one sample, bytes. */
enum { TRK_OWN_SIZE = 4096 };

/* Write the first two lines of a file, or the line of one sample. Return the length. */
size_t trk_own_header(bool with_screen, char out_text[TRK_OWN_SIZE]);
size_t trk_own_row(const struct trk_sample *sample, bool with_screen, char out_text[TRK_OWN_SIZE]);
/* Would trk_log_read() accept the sample's row? Valid fields must be finite, and directions of unit length.
 */
bool trk_own_accepts(const struct trk_sample *sample);

#endif
