/* report: what fovead tells people and scripts: what it loaded, how far it is, what it did. */
#ifndef FOVEAD_DAEMON_REPORT_H
#define FOVEAD_DAEMON_REPORT_H

#include <stdio.h>

#include "gaze.h"
#include "paint.h"
#include "picture.h"

/* One line on the scene, for the start line and for Welcome. */
void dmn_report_scene(const struct rnd_scene_info *info, const char *path, char *out_line, size_t size);

/* Lines of warnings on stderr. */
void dmn_report_warnings(const char *lines);

/* Print the scene's warnings on stderr, and a line on features that the file uses and the renderer lacks, if
 * there are any. */
void dmn_report_left_out(const struct rnd_scene_info *info, const char *path);

/* What has been said of a recording. All zero: nothing. */
struct dmn_told {
    bool fails, lost;
};
/* Say on stderr when a recording begins to fail, first loses samples, or goes on. */
void dmn_report_recording(struct dmn_told *told, const struct dmn_gaze_status *gaze);

/* Progress towards --until on stderr: on a terminal a bar, redrawn in place; else a line every few seconds.
 * All zero: nothing was printed. */
struct dmn_bar {
    uint64_t printed_ns;
    bool drawn;
};
void dmn_report_progress(struct dmn_bar *bar, const struct dmn_options *options, const struct dmn_work *work);
/* End the bar's line, if there is one. */
void dmn_report_progress_end(struct dmn_bar *bar);

/* The summary: a table, or with options->json one object; saved says whether options->save was written. */
void dmn_report_summary(const struct dmn_options *options, const struct dmn_picture *picture,
                        const struct dmn_work *work, const struct dmn_gaze_status *gaze, bool saved);

#endif
