/* device: the source that reads an eye tracker, of whatever kind. A thread looks for the device, opens it,
 * hands its samples to the reader, notices silence and unplugging, and looks again.
 *
 * A kind of device is one file with a `const struct trk_driver`, and one line in the table in tracker.c. A
 * driver's functions are called by one thread at a time for one device; list() by any. */
#ifndef FOVEAD_TRACKER_DEVICE_H
#define FOVEAD_TRACKER_DEVICE_H

#include "source/source.h"

struct trk_device;

/* What a driver knows of a device that it has opened. */
struct trk_device_facts {
    char description[320]; /* "NAME on PATH: what matters" */
    char remark[128];      /* the first of trk_device_news(), or "" */
    double rate_hz;        /* 0: unknown */
    unsigned clock_bits;   /* 0: it has no clock */
    double tick_ns;
};

struct trk_driver {
    const char *name;  /* what trk_source_options.spec says before the colon */
    const char *usage; /* as a user writes it */
    bool takes_path;
    /* Devices that are there. Fills up to room of out_devices; returns how many there are. */
    size_t (*list)(struct trk_device_info *out_devices, size_t room);
    /* Open the first that works, or the one at path if path is not NULL. NULL with an empty out_error if none
     * is there, with a line in it if one is and cannot be opened. options are as long-lived as the device. */
    void *(*open)(struct trk_device *device, const char *path, const struct trk_source_options *options,
                  struct trk_device_facts *out_facts, char out_error[TRK_ERROR_SIZE]);
    /* Wait for up to wait_ms and hand on what came by trk_device_deliver(). False when the device is gone. */
    bool (*step)(void *state, int wait_ms);
    void (*close)(void *state);
};

extern const struct trk_driver trk_hid, trk_psvr2;

/* Hand on a sample that reached us at arrival_ns: what it says and its valid bits; all else is filled in.
 * ticks: the device's clock, if it has one. For step() alone. */
void trk_device_deliver(struct trk_device *device, const struct trk_sample *sample, uint64_t ticks,
                        uint64_t arrival_ns);

/* Other news of the device that is open: its rate, if that is not 0, and a remark for people, such as that it
 * asks for calibration; NULL leaves the last one, "" takes it away. For step() alone. */
void trk_device_news(struct trk_device *device, double rate_hz, const char *remark);

/* A source that reads the first device of drivers (count of them; static). It is looked for once before this
 * returns: *out_present says if one was opened; if not, and out_error holds a line, one is there that cannot
 * be. NULL and a line in out_error when memory is short. */
struct trk_source *trk_device_open(const struct trk_driver *const *drivers, int count, const char *path,
                                   const struct trk_source_options *options, bool *out_present,
                                   char out_error[TRK_ERROR_SIZE]);

/* --- for auto ------------------------------------------------------------------------------------------- */

/* A source that replays the recording until a device is seen. Owns both from here on; NULL when memory is
 * short, and both are closed. device is from trk_device_open(). problem: why no device could be opened, or
 * "". */
struct trk_source *trk_auto_create(struct trk_source *recording, struct trk_source *device,
                                   const char *problem);

/* Keep only the newest sample that sees an eye, until trk_device_release(), and interrupt other when it
 * comes. */
void trk_device_hold(struct trk_source *source, struct trk_source *other);
/* Has one come since? */
bool trk_device_is_seen(struct trk_source *source);
void trk_device_release(struct trk_source *source);

#endif
