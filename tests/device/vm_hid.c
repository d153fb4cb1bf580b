/* vm_hid: make a page 0x12 eye tracker through the kernel's /dev/uhid, for the guest of vm.sh.
 *
 *   vm_hid REPORTS HZ
 *
 * Answers feature requests, waits until a program opens it, sends this many reports while it is open, and is
 * unplugged in the middle of its stream. */
#include "descriptors.h"
#include "hid_tracker.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static uint64_t now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000 + (uint64_t)now.tv_nsec / 1000;
}

static bool post(int file, const struct uhid_event *event)
{
    return write(file, event, sizeof *event) == (ssize_t)sizeof *event;
}

static bool create(int file)
{
    struct uhid_event event = {.type = UHID_CREATE2};
    struct uhid_create2_req *request = &event.u.create2;
    strcpy((char *)request->name, "Fovea Test Tracker");
    request->rd_size = sizeof reference_descriptor;
    memcpy(request->rd_data, reference_descriptor, sizeof reference_descriptor);
    request->bus = BUS_USB;
    request->vendor = HID_VENDOR;
    request->product = HID_PRODUCT;
    return post(file, &event);
}

static void answer(int file, const struct uhid_event *asked, unsigned hz)
{
    struct uhid_event event = {0};
    if (asked->type == UHID_GET_REPORT) {
        event.type = UHID_GET_REPORT_REPLY;
        event.u.get_report_reply.id = asked->u.get_report.id;
        event.u.get_report_reply.data[0] = asked->u.get_report.rnum;
        int size = hid_feature(event.u.get_report_reply.data, hz);
        event.u.get_report_reply.size = (uint16_t)size;
        event.u.get_report_reply.err = size ? 0 : EIO;
        post(file, &event);
    }
    if (asked->type == UHID_SET_REPORT) {
        event.type = UHID_SET_REPORT_REPLY;
        event.u.set_report_reply.id = asked->u.set_report.id;
        post(file, &event);
    }
}

int main(int count, char **arguments)
{
    uint64_t reports = count > 1 ? strtoull(arguments[1], NULL, 10) : 1000;
    unsigned hz = count > 2 ? (unsigned)atoi(arguments[2]) : 500;
    int file = open("/dev/uhid", O_RDWR | O_CLOEXEC);
    if (file < 0 || hz == 0 || !create(file)) {
        perror("vm_hid: /dev/uhid");
        return 2;
    }
    uint64_t period_us = 1000000 / hz, next_us = 0, sent = 0;
    bool is_open = false;
    while (sent < reports) {
        struct pollfd wait = {.fd = file, .events = POLLIN};
        uint64_t now = now_us();
        if (poll(&wait, 1,
                 is_open && next_us <= now ? 0
                 : is_open                 ? (int)((next_us - now + 999) / 1000)
                                           : 50) > 0) {
            struct uhid_event event;
            if (read(file, &event, sizeof event) < 0) break;
            if (event.type == UHID_OPEN) is_open = true;
            if (event.type == UHID_CLOSE) is_open = false;
            answer(file, &event, hz);
            continue;
        }
        if (!is_open || now_us() < next_us) continue;
        struct uhid_event event = {.type = UHID_INPUT2};
        event.u.input2.size = HID_REPORT;
        hid_fill(event.u.input2.data, sent++, now_us());
        if (!post(file, &event)) break;
        next_us = next_us + period_us > now ? next_us + period_us : now + period_us;
    }
    close(file); /* unplugged */
    printf("vm_hid: %llu reports\n", (unsigned long long)sent);
    return sent ? 0 : 1;
}
