/* auto: replays a log while there is no eye tracker, until one is plugged in and sees an eye. */
#ifndef FOVEAD_TRACKER_AUTO_H
#define FOVEAD_TRACKER_AUTO_H

#include "source/source.h"

/* A source that delivers the replay's samples until the device sees an eye, and the device's from then on. It
 * owns both. When memory is short, returns NULL and closes both. device is from trk_device_open(). problem:
 * why no device could be opened, or "". */
struct trk_source *trk_auto_create(struct trk_source *replay, struct trk_source *device, const char *problem);

#endif
