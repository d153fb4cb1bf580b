/* Shared by fake.c, fake_hid.c and fake_usb.c. */
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
    char node[64], system[4][256]; /* system: its nodes in sysfs, outermost first */
    int systems;
    UMockdevIoctlBase *handler;
    pthread_t thread;

    pthread_mutex_t lock; /* for all that follows: umockdev calls from a thread of its own */
    bool gone;
    int pty, read_end; /* our end of the terminal, and the end that the program has open too */
    GQueue reports;    /* of struct fake_report: not yet read */
    GQueue urbs, done; /* of struct urb in fake_usb.c: reads that wait, and completed ones */
    uint64_t sent, taken, sent_ns[FAKE_SENT];
    bool ready, said_ready; /* of FAKE_UNREADY */
    unsigned starts, stops;
    size_t calibration;
    const UMockdevIoctlClient *claimed_by; /* USB: the open file that has claimed the interface */
};

struct fake {
    UMockdevTestbed *bed;
    GMainLoop *loop; /* of the default context, for deferred answers */
    pthread_t thread;
    unsigned number; /* of the next device */
    GPtrArray *devices;
};

uint64_t fake_now_ns(void);
/* From now on, schedule the calling thread before all threads that compute. For every thread that acts for
 * the kernel. */
void fake_be_urgent(void);

/* The argument of an ioctl, with all of its bytes; NULL if they cannot be read. The caller unrefs it. */
UMockdevIoctlData *fake_ioctl_data(UMockdevIoctlClient *client);

/* Make the next report. Call with device->lock held. */
void fake_hid_fill(struct fake_device *device, struct fake_report *out_report);
void fake_usb_fill(struct fake_device *device, struct fake_report *out_report);
/* Append the description of the device in sysfs as umockdev reads it, and set node and system. */
void fake_hid_describe(struct fake_device *device, GString *out_text);
void fake_usb_describe(struct fake_device *device, GString *out_text);
gboolean fake_hid_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
gboolean fake_hid_read(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
gboolean fake_usb_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
void fake_usb_vanish(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer device);
/* Complete waiting reads with the reports that there are, or with an error if the device is gone. Call with
 * device->lock held. */
void fake_usb_pump(struct fake_device *device);
void fake_usb_finish(struct fake_device *device);

#endif
