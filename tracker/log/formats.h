/* formats: the table of log formats, and everything that a format needs.
 *
 * To add a format, write one file with a `const struct trk_log_format`, whose first comment describes the
 * format, and add a line to the table below and one to CMakeLists.txt. The format of a log is recognised by
 * the start of its content, never by its name. */
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
