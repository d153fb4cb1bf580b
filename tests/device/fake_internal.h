/* What fake.c, fake_hid.c and fake_usb.c share. */
#ifndef FOVEAD_TEST_FAKE_INTERNAL_H
#define FOVEAD_TEST_FAKE_INTERNAL_H

#include "fake.h"

#include <pthread.h>
#include <umockdev.h>

enum { FAKE_REPORT = 512, FAKE_SENT = 65536 };

struct fake_report {
    size_t size;
    uint8_t bytes[FAKE_REPORT];
};

struct fake_device {
    struct fake *fake;
    enum fake_kind kind;
    unsigned number;
    double hz;
    char node[64], system[4][256]; /* its nodes in sysfs, outermost first */
    int systems;
    UMockdevIoctlBase *handler;
    pthread_t thread;

    pthread_mutex_t lock; /* of all that follows: umockdev calls from a thread of its own */
    bool gone;
    int pty, read_end; /* the terminal's, and what the program has open too */
    GQueue reports;    /* struct fake_report, not yet read */
    GQueue urbs, done; /* struct urb of fake_usb.c: reads that wait, and what is to be reaped */
    uint64_t sent, taken, sent_ns[FAKE_SENT];
    bool ready, said_ready; /* of FAKE_UNREADY */
    unsigned starts, stops;
    size_t calibration;
    const UMockdevIoctlClient *claimed_by; /* USB: the file that has the interface */
};

struct fake {
    UMockdevTestbed *bed;
    GMainLoop *loop; /* of the default context: deferred answers */
    pthread_t thread;
    unsigned number; /* of the next device */
    GPtrArray *devices;
};

uint64_t fake_now_ns(void);
/* Run this thread before all that compute, from now on; for every thread that acts for the kernel. */
void fake_be_urgent(void);

/* The argument of a request to a device, all of its bytes; NULL if they cannot be had. The caller unrefs
 * it. */
UMockdevIoctlData *fake_ioctl_data(UMockdevIoctlClient *client);

/* The next report. Under device->lock. */
void fake_hid_fill(struct fake_device *device, struct fake_report *out_report);
void fake_usb_fill(struct fake_device *device, struct fake_report *out_report);
/* Add the sysfs description, as umockdev reads it, and set node and system. */
void fake_hid_describe(struct fake_device *device, GString *out_text);
void fake_usb_describe(struct fake_device *device, GString *out_text);
gboolean fake_hid_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
gboolean fake_hid_read(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
gboolean fake_usb_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
void fake_usb_vanish(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
/* Give waiting reads what there is, or when the device is gone an end. Under device->lock. */
void fake_usb_pump(struct fake_device *device);
void fake_usb_finish(struct fake_device *device);

#endif
