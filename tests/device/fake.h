/* fake: eye trackers in umockdev's test bed, for unmodified programs that run under its preload library.
 *
 * The bed answers as the kernel would: sysfs, uevents, hidraw and usbfs nodes. A node here is a link to a
 * pseudo-terminal of ours, because umockdev's own nodes can neither be waited for nor unplugged. One byte
 * waits in the terminal for each report, and closing it unplugs the device. Each device has a thread that
 * sends reports at its rate, stamped with CLOCK_MONOTONIC in microseconds. */
#ifndef FOVEAD_TEST_FAKE_H
#define FOVEAD_TEST_FAKE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct fake;        /* the test bed */
struct fake_device; /* something plugged into it */

enum fake_kind {
    FAKE_STILL,   /* like FAKE_HID, but its gaze rests */
    FAKE_HID,     /* a page 0x12 tracker with the reference descriptor; gaze goes around a circle */
    FAKE_UNREADY, /* like FAKE_HID; after 250 reports it asks for calibration, until it is made ready */
    FAKE_GARBAGE, /* like FAKE_HID, but reports are random bytes of random length */
    FAKE_BROKEN,  /* its descriptor begins as that of an eye tracker and is cut off */
    FAKE_PSVR2,
    FAKE_LATE,  /* like FAKE_PSVR2; a cancelled read returns gaze */
    FAKE_STUCK, /* like FAKE_PSVR2; a cancelled read never returns */
    FAKE_KINDS
};
extern const char *const fake_kind_names[FAKE_KINDS];

/* A process can have one bed. Programs that are started afterwards with LD_PRELOAD=libumockdev-preload.so.0
 * see its devices, and so does this program if it was started that way itself. Ends the program with a line
 * if the bed cannot be made. */
struct fake *fake_create(void);
void fake_destroy(struct fake *fake); /* unplugs all devices */

/* Plug in a device, which sends hz reports per second once it is opened. Node numbers count up. */
struct fake_device *fake_plug(struct fake *fake, enum fake_kind kind, double hz);
void fake_unplug(struct fake_device *device);

/* How many of its reports a program has read since it was plugged in. */
uint64_t fake_taken(struct fake_device *device);
/* Make a FAKE_UNREADY device report that its user is calibrated. */
void fake_make_ready(struct fake_device *device);

/* When report number n (from 0) was sent: ns of CLOCK_MONOTONIC. 0 if it was not sent, or if 64 Ki reports
 * have followed it. */
uint64_t fake_sent_ns(struct fake_device *device, uint64_t n);
/* How many requests to start (HID: the mode; USB: the keep-alive) and to stop have come, and how many bytes
 * of calibration. */
void fake_requests(struct fake_device *device, unsigned *out_start, unsigned *out_stop,
                   size_t *out_calibration);

#endif
