/* fake: eye trackers in umockdev's test bed, for unmodified programs that are run under its preload library.
 *
 * The bed answers as the kernel would: sysfs, uevents, hidraw and usbfs nodes. A node here is a link to a
 * pseudo-terminal of our own, since umockdev's can neither be waited for nor unplugged: one byte waits in it
 * for every report, and closing it is the unplugging. A thread for each device sends reports at its rate,
 * stamped with CLOCK_MONOTONIC in microseconds. */
#ifndef FOVEAD_TEST_FAKE_H
#define FOVEAD_TEST_FAKE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct fake;        /* the test bed */
struct fake_device; /* something plugged into it */

enum fake_kind {
    FAKE_STILL,   /* a page 0x12 tracker whose gaze rests; like the next in all else */
    FAKE_HID,     /* a page 0x12 tracker with the reference descriptor; gaze goes around a circle */
    FAKE_UNREADY, /* the same, that asks for its user to be calibrated after 250 reports, until it is made
                     ready */
    FAKE_GARBAGE, /* the same descriptor, and random bytes as reports, of random length */
    FAKE_BROKEN,  /* a descriptor that says it is an eye tracker and is cut off */
    FAKE_PSVR2,
    FAKE_LATE,  /* the same, whose reads come back with gaze when they are cancelled */
    FAKE_STUCK, /* the same, whose cancelled reads never come back */
    FAKE_KINDS
};
extern const char *const fake_kind_names[FAKE_KINDS];

/* One bed a process. Programs that are started afterwards with LD_PRELOAD=libumockdev-preload.so.0 are in it;
 * so is this one if it was itself. Aborts with a line when the bed cannot be made. */
struct fake *fake_create(void);
void fake_destroy(struct fake *fake); /* unplugs what is plugged in */

/* Plug in and start to send hz reports per second. Node numbers count up. */
struct fake_device *fake_plug(struct fake *fake, enum fake_kind kind, double hz);
void fake_unplug(struct fake_device *device);

/* How many of its reports a program has read since it was plugged in. */
uint64_t fake_taken(struct fake_device *device);
/* An unready one has a calibrated user from now on. */
void fake_make_ready(struct fake_device *device);

/* When report number n, from 0, was sent: CLOCK_MONOTONIC ns; 0 if it was not, or is more than 64 Ki ago. */
uint64_t fake_sent_ns(struct fake_device *device, uint64_t n);
/* Requests to start (HID: the mode; USB: the keep-alive) and to stop, and bytes of calibration that came. */
void fake_requests(struct fake_device *device, unsigned *out_start, unsigned *out_stop,
                   size_t *out_calibration);

#endif
