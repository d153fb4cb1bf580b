/* device: the source that reads an eye tracker of any kind. Its thread searches for the device, opens it,
 * passes its samples to the reader, notices silence and unplugging, and searches again. */
#ifndef FOVEAD_TRACKER_DEVICE_H
#define FOVEAD_TRACKER_DEVICE_H

#include "source/source.h"

/* What a row's attach() says about the device that it has opened. */
struct trk_device_facts {
    char description[320]; /* "NAME on PATH: details" */
    char remark[128];      /* the first remark, as in trk_device_news(), or "" */
    double rate_hz;        /* 0: unknown */
    unsigned clock_bits;   /* 0: it has no clock */
    double tick_ns;
    bool on_screen; /* as in trk_status */
};

/* Deliver a sample that arrived at arrival_ns. The row fills in what was measured and its valid bits, this
 * function the rest. ticks: the device's clock, if it has one. Only for step(). */
void trk_device_deliver(struct trk_device *device, const struct trk_sample *sample, uint64_t ticks,
                        uint64_t arrival_ns);

/* Report other news of the open device: its rate, unless that is 0, and a remark for people, for example that
 * it asks for calibration. NULL keeps the last remark, "" removes it. Only for step(). */
void trk_device_news(struct trk_device *device, double rate_hz, const char *remark);

/* A source that reads the first device that opens, among those of the `count` rows (static) that are devices.
 * It searches once before it returns: *out_present says whether a device was opened. If none was, and
 * out_error holds a line, then a device is plugged in that cannot be opened. NULL and a line in out_error
 * when memory is short. */
struct trk_source *trk_device_open(const struct trk_source_row *const *rows, int count, const char *path,
                                   const struct trk_source_options *options, bool *out_present,
                                   char out_error[TRK_ERROR_SIZE]);

/* --- for auto --- */

/* Until trk_device_release(): keep only the newest sample that sees an eye and the samples after it, and
 * interrupt `other` whenever one sees an eye. */
void trk_device_hold(struct trk_source *source, struct trk_source *other);
/* Has a sample seen an eye since trk_device_hold()? */
bool trk_device_sees_eye(struct trk_source *source);
void trk_device_release(struct trk_source *source);

#endif
