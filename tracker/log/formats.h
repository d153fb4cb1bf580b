/* formats: the table of log formats, and everything that a format is made with.
 *
 * A format is one file, which its own comment describes, with a `const struct trk_log_format`; a line in the
 * table below; and a line in CMakeLists.txt. A log's format is recognised by what the file begins with, never
 * by its name. */
#ifndef FOVEAD_TRACKER_LOG_FORMATS_H
#define FOVEAD_TRACKER_LOG_FORMATS_H

#include "gaze.h"
#include "log/clocks.h"
#include "log/convert.h"
#include "log/dialect.h"
#include "log/rows.h"
#include "log/table.h"

/* clang-format off */
#define TRK_LOG_FORMATS(FORMAT) \
    FORMAT(trk_log_own) \
    FORMAT(trk_log_sranipal) \
    FORMAT(trk_log_salient360_static) \
    FORMAT(trk_log_salient360_dynamic) \
    FORMAT(trk_log_pupil_core) \
    FORMAT(trk_log_pupil_cloud) \
    FORMAT(trk_log_tobii_lab) \
    FORMAT(trk_log_glasses3) \
    FORMAT(trk_log_pico) \
    FORMAT(trk_log_eyelink) \
    FORMAT(trk_log_gazepoint) \
    FORMAT(trk_log_open_gaze) \
    FORMAT(trk_log_gazebase) \
    FORMAT(trk_log_gazebase_vr) \
    FORMAT(trk_log_arff) \
    FORMAT(trk_log_pymovements) \
    FORMAT(trk_log_bids)
/* clang-format on */

#define TRK_LOG_DECLARE(format) extern const struct trk_log_format format;
TRK_LOG_FORMATS(TRK_LOG_DECLARE)
#undef TRK_LOG_DECLARE

#endif
