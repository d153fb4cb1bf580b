/* settings: what fovead was told on its command line. */
#ifndef FOVEAD_DAEMON_SETTINGS_H
#define FOVEAD_DAEMON_SETTINGS_H

#include "protocol.h"
#include "renderer.h"
#include "tracker.h"
#include "until.h"

enum { DMN_MAX_LISTEN = 8 };

struct dmn_options {
    struct rnd_scene_options scene;
    bool watch; /* take up edits of the scene's files */
    struct rnd_render_options render;
    const char *gaze; /* NULL: no source, so gaze does not steer samples */
    double speed;
    bool loop;
    bool raw_gaze, predict;
    struct trk_screen screen;
    const char *calibration; /* NULL: none */
    const char *record;      /* NULL: not recorded */
    bool replace;            /* an existing file may be replaced */
    float fov[2];            /* rad, of the vp viewport */
    float display_ppd;       /* pixels per degree; 0: no limit */
    bool virtual_clock;
    struct pro_address listen[DMN_MAX_LISTEN];
    int listens;
    char tls_certificate[4096]; /* paths of PEM files for listeners for browsers */
    const char *tls_key;        /* NULL: they speak no TLS */
    bool has_viewer;
    struct pro_address viewer; /* where tev or HDRView listens */
    struct dmn_until until;
    const char *save;             /* NULL: not saved */
    double save_every;            /* seconds; 0: only at the end */
    struct rnd_exposure exposure; /* of what is saved for displays */
    bool json;
    bool list_trackers;
};

#endif
