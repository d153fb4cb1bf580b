/* For test programs: what a browser sends to a port of this machine. */
#ifndef FOVEAD_TESTS_BROWSER_H
#define FOVEAD_TESTS_BROWSER_H

#include <errno.h>
#include <netinet/in.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* An hour: a loaded machine is forgiven all that a test may last. */
enum { BROWSER_PATIENCE_S = 3600, BROWSER_FRAME_HEADER = 14 };

/* A connection to a port of loopback. Ends the program if there is none. receive_buffer: bytes, or 0. */
static inline int browser_dial(int port, int receive_buffer)
{
    struct sockaddr_in name = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = BROWSER_PATIENCE_S};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);

    if (fd >= 0 && receive_buffer)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof(receive_buffer));
    if (fd < 0 || connect(fd, (struct sockaddr *)&name, sizeof(name))) {
        fprintf(stderr, "port %d: %s\n", port, strerror(errno));
        exit(2);
    }
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    return fd;
}

/* The request that opens a WebSocket. Returns its length. */
static inline size_t browser_handshake(int port, char *out_text, size_t size)
{
    return (size_t)snprintf(
        out_text, size,
        "GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nOrigin: http://127.0.0.1:%d\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: fovea\r\n\r\n",
        port, port);
}

/* A masked frame, as clients send, in room for count + BROWSER_FRAME_HEADER bytes. Returns its length. */
static inline size_t browser_frame(int opcode, const uint8_t *payload, size_t count, uint8_t *out_frame)
{
    static const uint8_t mask[4] = {0x12, 0x34, 0x56, 0x78};
    size_t at = 0;

    out_frame[at++] = (uint8_t)opcode;
    if (count < 126) {
        out_frame[at++] = (uint8_t)(0x80 | count);
    } else {
        const int bytes = count < 65536 ? 2 : 8;

        out_frame[at++] = (uint8_t)(0x80 | (bytes == 2 ? 126 : 127));
        for (int i = bytes - 1; i >= 0; i--) out_frame[at++] = (uint8_t)((uint64_t)count >> 8 * i);
    }
    memcpy(out_frame + at, mask, sizeof(mask));
    at += sizeof(mask);
    for (size_t i = 0; i < count; i++) out_frame[at++] = payload[i] ^ mask[i % 4];
    return at;
}

#endif
