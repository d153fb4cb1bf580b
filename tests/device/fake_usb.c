/* The PlayStation VR2 in the test bed: the usbfs requests that libusb makes. */
#include "fake_internal.h"

#include "psvr2.h"

#include <errno.h>
#include <sys/ioctl.h>
#include <linux/usbdevice_fs.h>
#include <stdio.h>
#include <string.h>

struct urb {
    UMockdevIoctlClient *client; /* the file that it was submitted to and is reaped from */
    UMockdevIoctlData *request, *buffer;
};

static const uint8_t descriptors[] = {
    /* device descriptor: USB 2, one configuration */
    18, 1, 0x00, 2, 0, 0, 0, 64, PSVR2_VENDOR & 255, PSVR2_VENDOR >> 8, PSVR2_PRODUCT & 255,
    PSVR2_PRODUCT >> 8, 0, 1, 0, 0, 0, 1,
    /* configuration descriptor: interface 5 with bulk endpoints 0x85 (in) and 0x05 (out) */
    9, 2, 9 + 9 + 7 + 7, 0, 1, 1, 0, 0x80, 50, 9, 4, PSVR2_INTERFACE, 0, 2, 0xff, 0, 0, 0, 7, 5, 0x85, 2,
    0x00, 2, 0, 7, 5, 0x05, 2, 0x00, 2, 0};

void fake_usb_describe(struct fake_device *device, GString *out_text)
{
    /* umockdev accepts every node only once: when the addresses of a bus are used up, take the next bus. */
    unsigned n = device->number, bus = 1 + n / 120, address = 2 + n % 120,
             minor = 128 * (bus - 1) + address - 1;
    snprintf(device->node, sizeof device->node, "/dev/bus/usb/%03u/%03u", bus, address);
    snprintf(device->system[0], sizeof device->system[0],
             "/sys/devices/pci0000:00/0000:00:14.0/usb%u/%u-2.%u", bus, bus, n);
    device->systems = 1;
    g_string_append_printf(
        out_text,
        "P: %s\nA: dev=189:%u\\n\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DEVNAME=%s\n"
        "E: BUSNUM=%03u\nE: DEVNUM=%03u\nE: MAJOR=189\nE: MINOR=%u\nE: PRODUCT=54c/cde/100\n",
        device->system[0] + 4, minor, device->node, bus, address, minor);
    g_string_append_printf(out_text,
                           "A: busnum=%u\\n\nA: devnum=%u\\n\nA: speed=480\\n\nA: bConfigurationValue=1\\n\n"
                           "A: idVendor=%04x\\n\nA: idProduct=%04x\\n\nA: bcdDevice=0100\\n\nH: descriptors=",
                           bus, address, PSVR2_VENDOR, PSVR2_PRODUCT);
    for (size_t i = 0; i < sizeof descriptors; i++) g_string_append_printf(out_text, "%02X", descriptors[i]);
    g_string_append(out_text, "\n");
}

/* Make packets of the two lengths that firmware sends, in turn. */
void fake_usb_fill(struct fake_device *device, struct fake_report *out_report)
{
    out_report->size = device->sent % 2 ? PSVR2_PACKET : PSVR2_PACKET - 4;
    psvr2_fill(out_report->bytes, fake_now_ns() / 1000);
}

static struct usbdevfs_urb *raw(const struct urb *urb)
{
    return (void *)urb->request->data;
}

static void free_urb(gpointer data)
{
    struct urb *urb = data;
    if (urb->buffer) g_object_unref(urb->buffer);
    g_object_unref(urb->request);
    g_free(urb);
}

/* Complete a read, with a report or with an error in `status`. */
static void complete(struct fake_device *device, struct urb *urb, const struct fake_report *report,
                     int status)
{
    raw(urb)->status = status;
    raw(urb)->actual_length = 0;
    if (report) {
        int size = (int)report->size < raw(urb)->buffer_length ? (int)report->size : raw(urb)->buffer_length;
        memcpy(urb->buffer->data, report->bytes, (size_t)size);
        raw(urb)->actual_length = size;
    }
    g_queue_push_tail(&device->done, urb);
}

void fake_usb_pump(struct fake_device *device)
{
    struct urb *urb;
    while ((device->gone || g_queue_get_length(&device->reports)) &&
           (urb = g_queue_pop_head(&device->urbs))) {
        struct fake_report *report = device->gone ? NULL : g_queue_pop_head(&device->reports);
        complete(device, urb, report, report ? 0 : -ENODEV);
        device->taken += report != NULL;
        g_free(report);
    }
}

static void drop_urbs(GQueue *urbs, const UMockdevIoctlClient *client)
{
    for (GList *at = urbs->head, *next; at; at = next) {
        struct urb *urb = at->data;
        next = at->next;
        if (urb->client != client) continue;
        g_queue_delete_link(urbs, at);
        free_urb(urb);
    }
}

/* The file was closed: like the kernel, drop the requests that were submitted to it, and its claim. */
void fake_usb_vanish(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer user)
{
    (void)base;
    struct fake_device *device = user;
    pthread_mutex_lock(&device->lock);
    drop_urbs(&device->urbs, client);
    drop_urbs(&device->done, client);
    if (device->claimed_by == client) device->claimed_by = NULL;
    pthread_mutex_unlock(&device->lock);
}

void fake_usb_finish(struct fake_device *device)
{
    g_queue_clear_full(&device->urbs, free_urb);
    g_queue_clear_full(&device->done, free_urb);
}

/* Take the vendor's request to start or stop. Any other request stalls. */
static void take_control(struct fake_device *device, struct urb *urb)
{
    const uint8_t *setup = urb->buffer->data;
    raw(urb)->status = -EPIPE;
    raw(urb)->actual_length = 0;
    if (setup[0] != 0x42 || setup[1] != 0x09 || raw(urb)->buffer_length < 16 || setup[8] != 0x0c) return;
    raw(urb)->status = 0;
    raw(urb)->actual_length = 8;
    if (setup[10] == 1 && device->starts == device->stops) device->starts++;
    if (setup[10] == 2 && device->starts > device->stops) device->stops++; /* not before the first start */
}

static int submit(struct fake_device *device, UMockdevIoctlClient *client, UMockdevIoctlData *data)
{
    struct usbdevfs_urb *request = (void *)data->data;
    if (device->gone) return -ENODEV;
    struct urb *urb = g_new0(struct urb, 1);
    urb->client = client;
    urb->request = g_object_ref(data);
    urb->buffer = umockdev_ioctl_data_resolve(data, G_STRUCT_OFFSET(struct usbdevfs_urb, buffer),
                                              (size_t)request->buffer_length, NULL);
    if (request->type == USBDEVFS_URB_TYPE_CONTROL) {
        take_control(device, urb);
    } else if (request->endpoint == 0x05) {
        device->calibration += (size_t)request->buffer_length;
        request->status = 0;
        request->actual_length = request->buffer_length;
    } else if (request->endpoint == 0x85) {
        g_queue_push_tail(&device->urbs, urb);
        fake_usb_pump(device);
        return 0;
    } else {
        free_urb(urb);
        return -ENOENT;
    }
    g_queue_push_tail(&device->done, urb);
    return 0;
}

/* A cancelled read returns at once. On FAKE_LATE it returns a report that was faster; on FAKE_STUCK it never
 * returns. */
static int discard(struct fake_device *device, const UMockdevIoctlClient *client, unsigned long address)
{
    for (GList *at = device->urbs.head; at; at = at->next) {
        struct urb *urb = at->data;
        if (urb->client != client || urb->request->client_addr != address) continue;
        if (device->kind == FAKE_STUCK) return 0;
        g_queue_delete_link(&device->urbs, at);
        if (device->kind == FAKE_LATE) {
            struct fake_report report;
            fake_usb_fill(device, &report);
            complete(device, urb, &report, 0);
            break;
        }
        complete(device, urb, NULL, -ENOENT);
        return 0;
    }
    return -EINVAL;
}

static int claim(struct fake_device *device, UMockdevIoctlClient *client)
{
    if (device->gone) return -ENODEV;
    if (device->claimed_by && device->claimed_by != client) return -EBUSY;
    device->claimed_by = client;
    return 0;
}

static int release(struct fake_device *device, const UMockdevIoctlClient *client)
{
    if (device->gone) return -ENODEV;
    if (device->claimed_by == client) device->claimed_by = NULL;
    return 0;
}

/* libusb waits until the node is ready for writing, and a pseudo-terminal always is. So answer "nothing yet"
 * after a millisecond; otherwise libusb would spin. */
static gboolean answer_later(gpointer client)
{
    umockdev_ioctl_client_complete(client, -1, EAGAIN);
    g_object_unref(client);
    return FALSE;
}

static int answer(struct fake_device *device, UMockdevIoctlClient *client, unsigned long request,
                  UMockdevIoctlData *data)
{
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        *(uint32_t *)data->data =
            USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
        return 0;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM: /* no driver holds it */
        return claim(device, client);
    case USBDEVFS_RELEASEINTERFACE:
        return release(device, client);
    case USBDEVFS_GETDRIVER:
        return -ENODATA;
    case USBDEVFS_SUBMITURB:
        return submit(device, client, data);
    case USBDEVFS_DISCARDURB:
        return discard(device, client, *(unsigned long *)umockdev_ioctl_client_get_arg(client)->data);
    default:
        return -ENOTTY;
    }
}

/* Return a completed request of this file; -ENODEV if the device is gone, or -EAGAIN if the caller has to
 * wait. */
static int reap(struct fake_device *device, const UMockdevIoctlClient *client, UMockdevIoctlData *data)
{
    for (GList *at = device->done.head; at; at = at->next) {
        struct urb *urb = at->data;
        if (urb->client != client) continue;
        g_queue_delete_link(&device->done, at);
        umockdev_ioctl_data_set_ptr(data, 0, urb->request);
        free_urb(urb);
        return 0;
    }
    return device->gone ? -ENODEV : -EAGAIN;
}

gboolean fake_usb_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer user)
{
    (void)base;
    struct fake_device *device = user;
    fake_be_urgent();
    unsigned long request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData *data = fake_ioctl_data(client);
    bool reaps = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
    pthread_mutex_lock(&device->lock);
    int result = reaps ? reap(device, client, data) : answer(device, client, request, data);
    pthread_mutex_unlock(&device->lock);
    if (data) g_object_unref(data);
    if (reaps && result == -EAGAIN)
        g_timeout_add(1, answer_later, g_object_ref(client)); /* umockdev drops a client without this */
    else
        umockdev_ioctl_client_complete(client, result < 0 ? -1 : result, result < 0 ? -result : 0);
    return TRUE;
}
