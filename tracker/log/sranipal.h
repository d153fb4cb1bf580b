/* Logs of HTC headsets (Vive Pro Eye, made through the SRanipal SDK) with head pose, from Unity. */
#ifndef FOVEAD_TRACKER_LOG_SRANIPAL_H
#define FOVEAD_TRACKER_LOG_SRANIPAL_H

#include "log/log.h"

extern const struct trk_log_format trk_log_sranipal;

#endif
