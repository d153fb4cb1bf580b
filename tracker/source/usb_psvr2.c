/* Eye trackers with a vendor's own USB interface, through libusb. So far there is one, the PlayStation VR2. A
 * tracker is described by a row of the table below and by the layout of its packets. */
#include "source/device.h"

#include "error.h"
#include "psvr2_packet.h"
#include "source/kinds.h"
#include "system.h"

#include <errno.h>
#include <libusb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    TRANSFERS = 4,    /* in flight at once, so that no packet is missed while one is handled */
    BUFFER = 16384,   /* a multiple of every packet size, or the transfer would overflow */
    MAX_PACKET = 512, /* bytes of a packet that are parsed */
    MAX_CALIBRATION = 1 << 20,
    MAX_ERRORS = 50,   /* in a row: the device has gone, whatever the bus says */
    PATIENCE_MS = 200, /* to wait for the answer to a request */
};
static const uint64_t retry_ns = 10000000, cancel_ns = 2000000000;

struct usb_tracker {
    uint16_t vendor, product;
    const char *name, *abilities;
    int interface;
    uint8_t in, out; /* bulk endpoints: in for gaze packets, out for calibration */
    /* The vendor requests that start the stream, which must be repeated, and stop it. */
    uint8_t request_type, request;
    uint16_t value;
    uint8_t start[8], stop[8];
    uint64_t again_ns;
    const struct trk_packet_layout *layout;
};

static const struct usb_tracker trackers[] = {
    {
        .vendor = 0x054c,
        .product = 0x0cde,
        .name = "PlayStation VR2",
        .abilities = "gaze of both eyes and combined, origins, pupils, blinks, device clock; a user's "
                     "calibration comes from a file",
        .interface = 5,
        .in = 0x85,
        .out = 0x05,
        .request_type = 0x42, /* to the device, of the vendor, recipient endpoint */
        .request = 0x09,
        .value = 0x000c, /* number of the report, which is also in the payload */
        .start = {0x0c, 0, 1, 0, 0, 0, 0, 0},
        .stop = {0x0c, 0, 2, 0, 0, 0, 0, 0},
        .again_ns = 1000000000,
        .layout = &trk_psvr2_layout,
    },
};
enum { TRACKERS = sizeof trackers / sizeof *trackers };

struct usb {
    struct trk_device *device;
    const struct usb_tracker *tracker;
    libusb_context *context;
    libusb_device_handle *handle;
    bool claimed, gone;
    bool closing; /* from now on nothing is delivered or submitted */
    struct usb_transfer {
        struct usb *usb;
        struct libusb_transfer *transfer;
        uint8_t *buffer;
        bool flying, stalled;
    } transfer[TRANSFERS];
    unsigned errors; /* how many transfers in a row have failed */
    uint64_t retry_at_ns, start_at_ns;
};

/* --- finding --- */

static const struct usb_tracker *recognise(libusb_device *device)
{
    struct libusb_device_descriptor descriptor;
    if (libusb_get_device_descriptor(device, &descriptor) != 0) return NULL;
    for (int i = 0; i < TRACKERS; i++)
        if (trackers[i].vendor == descriptor.idVendor && trackers[i].product == descriptor.idProduct)
            return &trackers[i];
    return NULL;
}

static bool open_handle(libusb_device *device, const struct usb_tracker *tracker,
                        libusb_device_handle **out_handle, char out_error[TRK_ERROR_SIZE])
{
    int result = libusb_open(device, out_handle);
    if (result == 0) return true;
    *out_handle = NULL;
    const char *advice =
        result == LIBUSB_ERROR_ACCESS
            ? "; install 70-fovead.rules into /etc/udev/rules.d or /lib/udev/rules.d, and plug "
              "it in again"
            : "";
    return trk_fail(out_error, "/dev/bus/usb/%03d/%03d (%s): %s%s", libusb_get_bus_number(device),
                    libusb_get_device_address(device), tracker->name, libusb_strerror(result), advice);
}

static size_t usb_list(struct trk_device_info *out_devices, size_t room)
{
    libusb_context *context;
    libusb_device **devices;
    size_t count = 0;
    if (libusb_init(&context) != 0) return 0;
    ssize_t all = libusb_get_device_list(context, &devices);
    for (ssize_t i = 0; i < all; i++) {
        const struct usb_tracker *tracker = recognise(devices[i]);
        if (!tracker || count++ >= room) continue;
        struct trk_device_info *info = &out_devices[count - 1];
        libusb_device_handle *handle;
        memset(info, 0, sizeof *info);
        snprintf(info->source, sizeof info->source, "psvr2");
        snprintf(info->name, sizeof info->name, "%s (%04x:%04x)", tracker->name, tracker->vendor,
                 tracker->product);
        snprintf(info->abilities, sizeof info->abilities, "%s", tracker->abilities);
        if (open_handle(devices[i], tracker, &handle, info->problem)) libusb_close(handle);
    }
    if (all >= 0) libusb_free_device_list(devices, 1);
    libusb_exit(context);
    return count;
}

/* --- reading --- */

static void submit(struct usb_transfer *t)
{
    int result = libusb_submit_transfer(t->transfer);
    t->flying = result == 0;
    if (result == LIBUSB_ERROR_NO_DEVICE || result == LIBUSB_ERROR_NOT_FOUND) t->usb->gone = true;
    if (result != 0) t->usb->errors++;
}

/* When a device is unplugged, its transfers may first fail with any error. usb_step() submits them again
 * until the bus says that the device has gone. */
static void LIBUSB_CALL on_transfer(struct libusb_transfer *transfer)
{
    uint64_t arrival_ns = trk_now_ns();
    struct usb_transfer *t = transfer->user_data;
    struct usb *usb = t->usb;
    uint8_t packet[MAX_PACKET];
    size_t size = transfer->actual_length < MAX_PACKET ? (size_t)transfer->actual_length : MAX_PACKET;
    enum libusb_transfer_status status = transfer->status;
    t->flying = false;
    if (status == LIBUSB_TRANSFER_NO_DEVICE) usb->gone = true;
    if (status == LIBUSB_TRANSFER_CANCELLED || usb->gone || usb->closing) return;
    if (status != LIBUSB_TRANSFER_COMPLETED) {
        usb->errors++;
        usb->retry_at_ns = arrival_ns + retry_ns;
        t->stalled = status == LIBUSB_TRANSFER_STALL;
        return;
    }
    memcpy(packet, t->buffer, size);
    submit(t);
    usb->errors = 0;

    struct trk_sample sample = {0};
    uint32_t clock;
    if (trk_packet_parse(usb->tracker->layout, packet, size, &sample, &clock))
        trk_device_deliver(usb->device, &sample, clock, arrival_ns);
}

static void request(struct usb *usb, const uint8_t payload[8])
{
    uint8_t copy[8];
    memcpy(copy, payload, sizeof copy);
    int result = libusb_control_transfer(usb->handle, usb->tracker->request_type, usb->tracker->request,
                                         usb->tracker->value, 0, copy, sizeof copy, PATIENCE_MS);
    if (result == LIBUSB_ERROR_NO_DEVICE) usb->gone = true;
}

static void submit_idle(struct usb *usb)
{
    for (int i = 0; i < TRANSFERS && !usb->gone; i++) {
        struct usb_transfer *t = &usb->transfer[i];
        if (t->flying) continue;
        if (t->stalled) libusb_clear_halt(usb->handle, usb->tracker->in);
        t->stalled = false;
        submit(t);
    }
}

static bool usb_step(void *handle, int wait_ms)
{
    struct usb *usb = handle;
    uint64_t now_ns = trk_now_ns();
    if (now_ns >= usb->retry_at_ns) {
        usb->retry_at_ns = now_ns + retry_ns;
        submit_idle(usb);
    }
    if (now_ns >= usb->start_at_ns) {
        usb->start_at_ns = now_ns + usb->tracker->again_ns;
        request(usb, usb->tracker->start);
    }
    struct timeval wait = {.tv_usec = 1000L * wait_ms};
    if (!usb->gone) libusb_handle_events_timeout_completed(usb->context, &wait, NULL);
    return !usb->gone && usb->errors < MAX_ERRORS;
}

/* --- opening and closing --- */

static bool send_calibration(struct usb *usb, const char *path, char out_error[TRK_ERROR_SIZE])
{
    int sent = 0, result = 0;
    FILE *file = fopen(path, "rbe");
    uint8_t *bytes = file ? malloc(MAX_CALIBRATION + 1) : NULL;
    size_t size = bytes ? fread(bytes, 1, MAX_CALIBRATION + 1, file) : 0;
    if (!file || !bytes || ferror(file))
        trk_fail(out_error, "%.256s: %s", path, strerror(errno));
    else if (size == 0 || size > MAX_CALIBRATION)
        trk_fail(out_error, "%.256s: expected a calibration of 1 to %d bytes", path, MAX_CALIBRATION);
    else if ((result = libusb_bulk_transfer(usb->handle, usb->tracker->out, bytes, (int)size, &sent,
                                            5 * PATIENCE_MS)) != 0 ||
             sent != (int)size)
        trk_fail(out_error, "%.256s: the %s took %d of %zu bytes of calibration: %s", path,
                 usb->tracker->name, sent, size, libusb_strerror(result));
    if (file) fclose(file);
    free(bytes);
    return !*out_error;
}

static bool is_flying(const struct usb *usb)
{
    for (int i = 0; i < TRANSFERS; i++)
        if (usb->transfer[i].flying) return true;
    return false;
}

/* The kernel owns the transfers in flight, and may still complete one that is being cancelled, so wait until
 * all have come back. If a broken bus keeps one, closing the handle takes it from the kernel and from libusb.
 * Either way no callback comes after the transfers have been freed. */
static void usb_detach(void *handle)
{
    struct usb *usb = handle;
    uint64_t end_ns = trk_now_ns() + cancel_ns;
    usb->closing = true;
    if (usb->claimed && !usb->gone) request(usb, usb->tracker->stop);
    for (int i = 0; i < TRANSFERS; i++)
        if (usb->transfer[i].flying) libusb_cancel_transfer(usb->transfer[i].transfer);
    while (is_flying(usb) && trk_now_ns() < end_ns) {
        struct timeval wait = {.tv_usec = 10000};
        libusb_handle_events_timeout_completed(usb->context, &wait, NULL);
    }
    if (usb->claimed) libusb_release_interface(usb->handle, usb->tracker->interface);
    if (usb->handle) libusb_close(usb->handle);
    for (int i = 0; i < TRANSFERS; i++) {
        libusb_free_transfer(usb->transfer[i].transfer);
        free(usb->transfer[i].buffer);
    }
    libusb_exit(usb->context);
    free(usb);
}

static bool prepare(struct usb *usb)
{
    for (int i = 0; i < TRANSFERS; i++) {
        struct usb_transfer *t = &usb->transfer[i];
        t->usb = usb;
        t->transfer = libusb_alloc_transfer(0);
        t->buffer = malloc(BUFFER);
        if (!t->transfer || !t->buffer) return false;
        libusb_fill_bulk_transfer(t->transfer, usb->handle, usb->tracker->in, t->buffer, BUFFER, on_transfer,
                                  t, 0);
    }
    return true;
}

static bool start(struct usb *usb, libusb_device *device, const char *calibration,
                  char out_error[TRK_ERROR_SIZE])
{
    if (!open_handle(device, usb->tracker, &usb->handle, out_error)) return false;
    libusb_set_auto_detach_kernel_driver(usb->handle, 1);
    int result = libusb_claim_interface(usb->handle, usb->tracker->interface);
    if (result != 0)
        return trk_fail(out_error, "%s: interface %d: %s%s", usb->tracker->name, usb->tracker->interface,
                        libusb_strerror(result),
                        result == LIBUSB_ERROR_BUSY ? "; another program reads its gaze" : "");
    usb->claimed = true;
    if (!prepare(usb)) return trk_fail(out_error, "%s: no memory", usb->tracker->name);
    return !calibration || send_calibration(usb, calibration, out_error);
}

static void *usb_attach(struct trk_device *device, const char *path, const struct trk_source_options *options,
                        struct trk_device_facts *out_facts, char out_error[TRK_ERROR_SIZE])
{
    (void)path;
    libusb_device **devices;
    struct usb *usb = calloc(1, sizeof *usb);
    if (!usb || libusb_init(&usb->context) != 0) { /* no USB here */
        free(usb);
        return NULL;
    }
    usb->device = device;
    ssize_t all = libusb_get_device_list(usb->context, &devices);
    libusb_device *found = NULL;
    for (ssize_t i = 0; i < all && !found; i++)
        if ((usb->tracker = recognise(devices[i]))) found = devices[i];
    bool started = found && start(usb, found, options->calibration, out_error);
    if (started) {
        snprintf(out_facts->description, sizeof out_facts->description, "%s on /dev/bus/usb/%03d/%03d: %s",
                 usb->tracker->name, libusb_get_bus_number(found), libusb_get_device_address(found),
                 options->calibration ? "calibrated from a file" : "no calibration given, gaze may be off");
        out_facts->clock_bits = 32;
        out_facts->tick_ns = usb->tracker->layout->clock_tick_ns;
    }
    if (all >= 0) libusb_free_device_list(devices, 1);
    if (started) return usb;
    usb_detach(usb);
    return NULL;
}

const struct trk_source_row trk_psvr2 = {
    .kind = {.name = "psvr2",
             .usage = "psvr2",
             .summary = "a PlayStation VR2",
             .is_device = true,
             .takes_calibration = true,
             .follows_eye = true,
             .needs_real_clock = true},
    .list = usb_list,
    .attach = usb_attach,
    .step = usb_step,
    .detach = usb_detach,
};
