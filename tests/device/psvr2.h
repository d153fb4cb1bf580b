/* A gaze packet of the PlayStation VR2, written field by field from public descriptions, with a different
 * value in each field. For the tests and the fake device. */
#ifndef FOVEAD_TEST_PSVR2_H
#define FOVEAD_TEST_PSVR2_H

#include <stdint.h>
#include <string.h>

enum { PSVR2_VENDOR = 0x054c, PSVR2_PRODUCT = 0x0cde, PSVR2_INTERFACE = 5, PSVR2_PACKET = 328 };

static inline void psvr2_u32(uint8_t *packet, size_t at, uint32_t value)
{
    for (int i = 0; i < 4; i++) packet[at + (size_t)i] = (uint8_t)(value >> 8 * i);
}

static inline void psvr2_vector(uint8_t *packet, size_t at, float x, float y, float z)
{
    const float v[3] = {x, y, z};
    for (size_t i = 0; i < 3; i++) {
        uint32_t bits;
        memcpy(&bits, &v[i], sizeof bits);
        psvr2_u32(packet, at + 4 * i, bits);
    }
}

/* Fill a packet. It is in the headset's frame: +X left, +Y up, +Z forward; millimetres. The right lid is
 * closed. */
static inline void psvr2_fill(uint8_t packet[PSVR2_PACKET], uint64_t clock_us)
{
    memset(packet, 0, PSVR2_PACKET);
    memcpy(packet, "GS", 2);
    psvr2_u32(packet, 0x004, PSVR2_PACKET);
    packet[0x04c] = 2;
    psvr2_u32(packet, 0x050, (uint32_t)clock_us);
    psvr2_u32(packet, 0x054, (uint32_t)(clock_us >> 32));
    for (size_t eye = 0; eye < 2; eye++) {
        size_t at = eye ? 0x0a4 : 0x05c;
        float side = eye ? -1 : 1;
        for (size_t flag = 0; flag <= 0x40; flag += 0x10) psvr2_u32(packet, at + flag, flag == 0x30 ? 0 : 1);
        psvr2_vector(packet, at + 0x04, 32 * side, 1, 2);
        psvr2_vector(packet, at + 0x14, 0, 0.6f * side, 0.8f);
        psvr2_vector(packet, at + 0x24, eye ? 4.5f : 3.5f, 0, 0);
        psvr2_u32(packet, at + 0x28, 1);
        psvr2_u32(packet, at + 0x34, 1);
        psvr2_u32(packet, at + 0x44, eye != 0);
    }
    psvr2_u32(packet, 0x0ec, 1);
    psvr2_vector(packet, 0x0f0, -1, 2, 3);
    psvr2_u32(packet, 0x0fc, 1);
    psvr2_vector(packet, 0x100, -0.6f, 0, 0.8f);
    psvr2_u32(packet, 0x10c, 1);
    psvr2_u32(packet, 0x110, (uint32_t)clock_us);
    psvr2_vector(packet, 0x138, -0.6f, 0, 0.8f);
    psvr2_vector(packet, 0x13c, 0, 0.8f, 900); /* the convergence distance at the end of the packet */
}

#endif
