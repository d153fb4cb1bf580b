/* The log formats, each described at the top of its file. */
#ifndef FOVEAD_TRACKER_LOG_FORMATS_H
#define FOVEAD_TRACKER_LOG_FORMATS_H

#include "log/log.h"

extern const struct trk_log_format trk_log_own;
extern const struct trk_log_format trk_log_sranipal;
extern const struct trk_log_format trk_log_salient360_static;
extern const struct trk_log_format trk_log_salient360_dynamic;
extern const struct trk_log_format trk_log_pupil_core;
extern const struct trk_log_format trk_log_pupil_cloud;
extern const struct trk_log_format trk_log_tobii_lab;
extern const struct trk_log_format trk_log_glasses3;
extern const struct trk_log_format trk_log_pico;
extern const struct trk_log_format trk_log_eyelink;
extern const struct trk_log_format trk_log_gazepoint;
extern const struct trk_log_format trk_log_open_gaze;
extern const struct trk_log_format trk_log_gazebase;
extern const struct trk_log_format trk_log_gazebase_vr;
extern const struct trk_log_format trk_log_arff;
extern const struct trk_log_format trk_log_pymovements;
extern const struct trk_log_format trk_log_bids;

#endif
