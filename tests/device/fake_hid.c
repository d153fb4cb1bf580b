/* The HID tracker in the test bed: ioctls and reports of hidraw. */
#include "fake_internal.h"

#include "descriptors.h"
#include "hid_tracker.h"

#include <errno.h>
#include <sys/ioctl.h>
#include <linux/hidraw.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define PORT "/sys/devices/pci0000:00/0000:00:14.0/usb1/1-1"

enum { CUT = 40 };

static size_t descriptor_size(const struct fake_device *device)
{
    return device->kind == FAKE_BROKEN ? CUT : sizeof reference_descriptor;
}

void fake_hid_describe(struct fake_device *device, GString *out_text)
{
    unsigned n = device->number;
    char id[32];
    snprintf(device->node, sizeof device->node, "/dev/hidraw%u", n);
    snprintf(id, sizeof id, "0003:DEED:FEED.%04X", n + 1);
    /* Give each device a port of its own, because several may be plugged in at once. */
    snprintf(device->system[0], sizeof device->system[0], PORT ".%u", n);
    snprintf(device->system[1], sizeof device->system[1], PORT ".%u/1-1.%u:1.0", n, n);
    snprintf(device->system[2], sizeof device->system[2], PORT ".%u/1-1.%u:1.0/%s", n, n, id);
    snprintf(device->system[3], sizeof device->system[3], PORT ".%u/1-1.%u:1.0/%s/hidraw/hidraw%u", n, n, id,
             n);
    device->systems = 4;
    g_string_append_printf(out_text,
                           "P: %s\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: PRODUCT=deed/feed/100\n"
                           "A: idVendor=deed\\n\nA: idProduct=feed\\n\nA: manufacturer=Fovea\\n\n"
                           "A: product=Test Tracker\\n\nA: serial=%u\\n\nA: bcdDevice=0100\\n\n\n",
                           device->system[0] + 4, n);
    g_string_append_printf(out_text,
                           "P: %s\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nE: DRIVER=usbhid\n"
                           "A: bInterfaceNumber=00\\n\nA: bInterfaceClass=03\\n\n\n",
                           device->system[1] + 4);
    g_string_append_printf(
        out_text,
        "P: %s\nE: SUBSYSTEM=hid\nE: DRIVER=hid-generic\nE: HID_ID=0003:0000DEED:0000FEED\n"
        "E: HID_NAME=Fovea Test Tracker\nE: HID_UNIQ=%u\nH: report_descriptor=",
        device->system[2] + 4, n);
    for (size_t i = 0; i < descriptor_size(device); i++)
        g_string_append_printf(out_text, "%02X", reference_descriptor[i]);
    g_string_append_printf(out_text,
                           "\n\nP: %s\nA: dev=242:%u\\n\nE: SUBSYSTEM=hidraw\nE: DEVNAME=%s\nE: MAJOR=242\n"
                           "E: MINOR=%u\nL: device=../../../%s\n",
                           device->system[3] + 4, n, device->node, n, id);
}

void fake_hid_fill(struct fake_device *device, struct fake_report *out_report)
{
    const bool says_ready = device->ready && !device->said_ready;
    if (device->kind == FAKE_UNREADY && (device->sent == 250 || says_ready)) {
        out_report->size = hid_status(out_report->bytes, says_ready ? 1 : 4, (unsigned)device->hz);
        device->said_ready = says_ready;
        return;
    }
    if (device->kind != FAKE_GARBAGE) {
        out_report->size = HID_REPORT;
        hid_fill(out_report->bytes, device->kind == FAKE_STILL ? 0 : device->sent, fake_now_ns() / 1000);
        return;
    }
    uint64_t state = device->sent * 2654435761u + 1;
    out_report->size = 1 + device->sent * 7 % 80;
    for (size_t i = 0; i < out_report->size; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        out_report->bytes[i] = (uint8_t)(state >> 56);
    }
    /* In half of the reports, use an id that exists. */
    if (device->sent % 2) out_report->bytes[0] = device->sent % 4 == 1 ? 0x10 : 0x13;
}

static int get_feature(const struct fake_device *device, uint8_t *out, size_t size)
{
    uint8_t report[19] = {out[0]};
    int length = hid_feature(report, (unsigned)device->hz);
    if (length > (int)size) length = (int)size;
    memcpy(out, report, (size_t)length);
    return length ? length : -1;
}

static int set_feature(struct fake_device *device, const uint8_t *bytes, size_t size)
{
    if (size < 2 || bytes[0] != 0x14) return -1;
    if (bytes[1])
        device->starts++;
    else
        device->stops++;
    return (int)size;
}

static int answer(struct fake_device *device, unsigned long request, UMockdevIoctlData *data)
{
    if (request == HIDIOCGRDESCSIZE) {
        *(int *)data->data = (int)descriptor_size(device);
        return 0;
    }
    if (request == HIDIOCGRDESC) {
        struct hidraw_report_descriptor *descriptor = (void *)data->data;
        descriptor->size = (uint32_t)descriptor_size(device);
        memcpy(descriptor->value, reference_descriptor, descriptor_size(device));
        return 0;
    }
    if (request == HIDIOCGRAWINFO) {
        *(struct hidraw_devinfo *)data->data = (struct hidraw_devinfo){3, (int16_t)0xdeed, (int16_t)0xfeed};
        return 0;
    }
    if (_IOC_TYPE(request) == 'H' && _IOC_NR(request) == 0x07)
        return get_feature(device, data->data, _IOC_SIZE(request));
    if (_IOC_TYPE(request) == 'H' && _IOC_NR(request) == 0x06)
        return set_feature(device, data->data, _IOC_SIZE(request));
    return -1;
}

gboolean fake_hid_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer user)
{
    (void)base;
    struct fake_device *device = user;
    fake_be_urgent();
    unsigned long request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData *data = fake_ioctl_data(client);
    pthread_mutex_lock(&device->lock);
    bool gone = device->gone;
    int result = gone || !data ? -1 : answer(device, request, data);
    pthread_mutex_unlock(&device->lock);
    if (data) g_object_unref(data);
    umockdev_ioctl_client_complete(client, result, result >= 0 ? 0 : gone ? ENODEV : EPIPE);
    return TRUE;
}

/* Return one report per read, and take the byte that stands for it out of the terminal. */
gboolean fake_hid_read(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer user)
{
    (void)base;
    struct fake_device *device = user;
    fake_be_urgent();
    pthread_mutex_lock(&device->lock);
    struct fake_report *report = device->gone ? NULL : g_queue_pop_head(&device->reports);
    size_t size = 0;
    char byte;
    if (report) {
        UMockdevIoctlData *data = umockdev_ioctl_client_get_arg(client);
        size = report->size < (size_t)data->data_len ? report->size : (size_t)data->data_len;
        memcpy(data->data, report->bytes, size);
        device->taken++;
        if (read(device->read_end, &byte, 1) != 1) perror("fake tracker: pty");
    }
    int failure = device->gone ? EIO : EAGAIN;
    pthread_mutex_unlock(&device->lock);
    umockdev_ioctl_client_complete(client, report ? (long)size : -1, report ? 0 : failure);
    g_free(report);
    return TRUE;
}
