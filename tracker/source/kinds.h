/* kinds: the table of gaze sources. Each row is in the file of its source. The row of auto, which chooses
 * among the others, is in sources.c. */
#ifndef FOVEAD_TRACKER_KINDS_H
#define FOVEAD_TRACKER_KINDS_H

#include "source/source.h"

/* auto tries devices in this order. */
/* clang-format off */
#define TRK_SOURCE_KINDS(KIND) \
    KIND(trk_hid) \
    KIND(trk_psvr2) \
    KIND(trk_replay) \
    KIND(trk_synthetic) \
    KIND(trk_pointer)
/* clang-format on */

#define TRK_SOURCE_DECLARE(row) extern const struct trk_source_row row;
TRK_SOURCE_KINDS(TRK_SOURCE_DECLARE)
#undef TRK_SOURCE_DECLARE

#endif
