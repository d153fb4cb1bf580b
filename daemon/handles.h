/* handles: the parts of a running daemon, for the files that serve clients. */
#ifndef FOVEAD_DAEMON_HANDLES_H
#define FOVEAD_DAEMON_HANDLES_H

struct dmn_handles {
    const struct dmn_options *options;
    struct rnd_render *render;
    struct dmn_gaze *gaze;
    struct dmn_painter *painter;
    struct dmn_jobs *jobs;
    struct dmn_edits *edits; /* NULL: the scene's files are not watched */
};

#endif
