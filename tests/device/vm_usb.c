/* vm_usb: make a PlayStation VR2 that the kernel's vhci_hcd sees over USB/IP, for the guest of vm.sh. There
 * is no network: the link is a socket pair, and one end of it is handed to the kernel.
 *
 *   vm_usb PACKETS HZ
 *
 * Waits until a program asks it to stream, sends this many packets, and is unplugged in the middle. Messages
 * follow the kernel's Documentation/usb/usbip_protocol.rst: 48 bytes, big-endian, then data. */
#include "psvr2.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { SUBMIT = 1, UNLINK = 2, HEADER = 48, MAX_WAITING = 64, MAX_DATA = 65536 };

static const uint8_t device_descriptor[] = {18,
                                            1,
                                            0x00,
                                            2,
                                            0,
                                            0,
                                            0,
                                            64,
                                            PSVR2_VENDOR & 255,
                                            PSVR2_VENDOR >> 8,
                                            PSVR2_PRODUCT & 255,
                                            PSVR2_PRODUCT >> 8,
                                            0,
                                            1,
                                            0,
                                            0,
                                            0,
                                            1};
static const uint8_t configuration[] = {9,    2,    9 + 9 + 7 + 7,
                                        0,    1,    1,
                                        0,    0x80, 50,
                                        9,    4,    PSVR2_INTERFACE,
                                        0,    2,    0xff,
                                        0,    0,    0,
                                        7,    5,    0x85,
                                        2,    0x00, 2,
                                        0,    7,    5,
                                        0x05, 2,    0x00,
                                        2,    0};

struct usb {
    int link;
    bool streams, gone;
    struct {
        uint32_t number, length;
    } waiting[MAX_WAITING]; /* reads of gaze */
    int waits;
};

static uint64_t now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000 + (uint64_t)now.tv_nsec / 1000;
}

static void transfer(struct usb *usb, void *bytes, size_t size, bool out)
{
    uint8_t *at = bytes;
    while (size && !usb->gone) {
        ssize_t done = out ? send(usb->link, at, size, MSG_NOSIGNAL) : recv(usb->link, at, size, 0);
        if (done <= 0) usb->gone = true;
        if (done > 0) at += done, size -= (size_t)done;
    }
}

/* length: of `data`, or of the data that was taken. */
static void reply(struct usb *usb, uint32_t command, uint32_t number, int status, const void *data,
                  uint32_t length)
{
    static uint8_t message[HEADER + MAX_DATA];
    uint32_t words[HEADER / 4] = {
        htonl(command + 2), htonl(number), 0, 0, 0, htonl((uint32_t)status), htonl(length), 0,
        htonl(0xffffffff)};
    memcpy(message, words, HEADER);
    if (data) memcpy(message + HEADER, data, length);
    transfer(usb, message, HEADER + (data ? length : 0), true);
}

static void control(struct usb *usb, uint32_t number, const uint8_t *setup, const uint8_t *data,
                    uint32_t length)
{
    static const uint8_t zero[2] = {0, 0}, one[1] = {1};
    const uint8_t *answer = NULL;
    uint32_t size = 0;
    if (setup[0] == 0x80 && setup[1] == 6 && setup[3] == 1)
        answer = device_descriptor, size = sizeof device_descriptor;
    if (setup[0] == 0x80 && setup[1] == 6 && setup[3] == 2)
        answer = configuration, size = sizeof configuration;
    if ((setup[0] & 0x80) && setup[1] == 0) answer = zero, size = 2;
    if (setup[0] == 0x80 && setup[1] == 8) answer = one, size = 1;
    if (setup[0] == 0x42 && setup[1] == 9 && length >= 8 && data[0] == 0x0c) usb->streams = data[2] == 1;
    if (!(setup[0] & 0x80))
        reply(usb, SUBMIT, number, 0, NULL, length);
    else if (answer)
        reply(usb, SUBMIT, number, 0, answer, size < length ? size : length);
    else
        reply(usb, SUBMIT, number, -EPIPE, NULL, 0);
}

static void take(struct usb *usb)
{
    static uint8_t data[MAX_DATA];
    uint32_t words[HEADER / 4];
    transfer(usb, words, HEADER, false);
    uint32_t command = ntohl(words[0]), number = ntohl(words[1]), in = ntohl(words[3]),
             endpoint = ntohl(words[4]);
    if (usb->gone) return;
    if (command == UNLINK) {
        int status = 0;
        for (int i = 0; i < usb->waits; i++)
            if (usb->waiting[i].number == ntohl(words[5])) {
                usb->waiting[i] = usb->waiting[--usb->waits];
                status = -ECONNRESET;
            }
        reply(usb, UNLINK, number, status, NULL, 0);
        return;
    }
    uint32_t length = ntohl(words[6]);
    if (length > sizeof data) usb->gone = true;
    if (!in) transfer(usb, data, length, false);
    if (usb->gone) return;
    if (endpoint == 0)
        control(usb, number, (const uint8_t *)&words[10], data, length);
    else if (in && endpoint == 5 && usb->waits < MAX_WAITING)
        usb->waiting[usb->waits].number = number, usb->waiting[usb->waits++].length = length;
    else
        reply(usb, SUBMIT, number, in ? -EPIPE : 0, NULL, in ? 0 : length);
}

static void send_gaze(struct usb *usb)
{
    uint8_t packet[PSVR2_PACKET];
    if (!usb->waits) return;
    uint32_t number = usb->waiting[0].number, length = usb->waiting[0].length;
    memmove(usb->waiting, usb->waiting + 1, (size_t)--usb->waits * sizeof *usb->waiting);
    psvr2_fill(packet, now_us());
    reply(usb, SUBMIT, number, 0, packet, length < PSVR2_PACKET ? length : PSVR2_PACKET);
}

static bool attach(int theirs)
{
    char text[64];
    int file = open("/sys/devices/platform/vhci_hcd.0/attach", O_WRONLY | O_CLOEXEC);
    int length =
        snprintf(text, sizeof text, "0 %d 65538 3", theirs); /* port, socket, device id, high speed */
    ssize_t written;
    /* The port may still be busy with the device that was just unplugged. */
    while ((written = write(file, text, (size_t)length)) != length && (errno == EBUSY || errno == EINVAL))
        nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    if (file >= 0) close(file);
    return written == length;
}

int main(int count, char **arguments)
{
    uint64_t packets = count > 1 ? strtoull(arguments[1], NULL, 10) : 1000;
    int hz = count > 2 ? atoi(arguments[2]) : 500, ends[2];
    struct usb usb = {0};
    if (hz <= 0 || socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0 || !attach(ends[1])) {
        perror("vm_usb: vhci_hcd");
        return 2;
    }
    close(ends[1]);
    usb.link = ends[0];
    uint64_t period_us = 1000000 / (uint64_t)hz, next_us = 0, sent = 0;
    while (!usb.gone && sent < packets) {
        struct pollfd wait = {.fd = usb.link, .events = POLLIN};
        uint64_t now = now_us();
        if (poll(&wait, 1, !usb.streams ? 50 : next_us <= now ? 0 : (int)((next_us - now + 999) / 1000)) > 0)
            take(&usb);
        if (!usb.streams || now_us() < next_us) continue;
        sent += usb.waits > 0;
        send_gaze(&usb);
        next_us = next_us + period_us > now ? next_us + period_us : now + period_us;
    }
    close(usb.link); /* unplugged */
    printf("vm_usb: %llu packets\n", (unsigned long long)sent);
    return sent ? 0 : 1;
}
