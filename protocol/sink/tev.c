/* tev.c: packets for the viewers tev and HDRView. A packet is its length, which counts itself, a byte for its
 * kind, and its content; all little-endian, without padding. Layouts by tev's include/tev/Ipc.h and
 * include/tev/VectorGraphics.h (Müller, https://github.com/Tom94/tev). */
#include "protocol.h"

#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "values are copied as they are");

enum { CREATE_IMAGE = 4, UPDATE_IMAGE_V3 = 6, VECTOR_GRAPHICS = 8 };

/* A packet that is being written, or, while bytes is NULL, measured. */
struct packet {
    uint8_t *bytes;
    size_t count;
};

static void put(struct packet *packet, const void *value, size_t size)
{
    if (packet->bytes) memcpy(packet->bytes + packet->count, value, size);
    packet->count += size;
}

static void put_byte(struct packet *packet, uint8_t value)
{
    put(packet, &value, sizeof value);
}

static void put_int(struct packet *packet, int32_t value)
{
    put(packet, &value, sizeof value);
}

static void put_text(struct packet *packet, const char *text)
{
    put(packet, text, strlen(text) + 1);
}

/* The length, which is 0 while the packet is measured, and the kind. */
static struct packet begin(uint8_t *bytes, size_t length, uint8_t kind)
{
    struct packet packet = {.bytes = bytes};
    put_int(&packet, (int32_t)(uint32_t)length);
    put_byte(&packet, kind);
    return packet;
}

/* Room for a packet that was measured. NULL if memory is short, or if its length does not fit its field. */
static uint8_t *room_for(const struct packet *measured, size_t *out_count)
{
    *out_count = measured->count;
    return measured->count <= UINT32_MAX ? malloc(measured->count) : NULL;
}

static struct packet create(uint8_t *bytes, size_t length, const struct pro_tev_image *image)
{
    struct packet packet = begin(bytes, length, CREATE_IMAGE);
    put_byte(&packet, true); /* it is shown at once */
    put_text(&packet, image->name);
    put_int(&packet, image->width);
    put_int(&packet, image->height);
    put_int(&packet, image->channels);
    for (int i = 0; i < image->channels; i++) put_text(&packet, image->channel[i]);
    return packet;
}

uint8_t *pro_tev_create(const struct pro_tev_image *image, size_t *out_count)
{
    const struct packet measured = create(NULL, 0, image);
    uint8_t *bytes = room_for(&measured, out_count);
    if (bytes) create(bytes, measured.count, image);
    return bytes;
}

static struct packet update(uint8_t *bytes, size_t length, const struct pro_tev_image *image,
                            const struct pro_tev_part *part)
{
    struct packet packet = begin(bytes, length, UPDATE_IMAGE_V3);
    put_byte(&packet, false); /* what the user looks at stays shown */
    put_text(&packet, image->name);
    put_int(&packet, image->channels);
    for (int i = 0; i < image->channels; i++) put_text(&packet, image->channel[i]);
    put_int(&packet, part->x);
    put_int(&packet, part->y);
    put_int(&packet, part->width);
    put_int(&packet, part->height);
    /* In floats: where a channel's first value is, and how far it is to that of the next pixel. */
    for (int64_t i = 0; i < image->channels; i++) put(&packet, &i, sizeof i);
    for (int i = 0; i < image->channels; i++) put(&packet, &(int64_t){image->channels}, sizeof(int64_t));
    put(&packet, part->values,
        sizeof *part->values * (size_t)part->width * (size_t)part->height * (size_t)image->channels);
    return packet;
}

uint8_t *pro_tev_update(const struct pro_tev_image *image, const struct pro_tev_part *part, size_t *out_count)
{
    const struct packet measured = update(NULL, 0, image, part);
    uint8_t *bytes = room_for(&measured, out_count);
    if (bytes) update(bytes, measured.count, image, part);
    return bytes;
}

/* How many of its arguments a command has. */
static size_t arguments_of(enum pro_tev_pen pen)
{
    switch (pen) {
    case PRO_TEV_COLOUR:
        return 4;
    case PRO_TEV_MOVE_TO:
    case PRO_TEV_LINE_TO:
        return 2;
    case PRO_TEV_BEGIN:
    case PRO_TEV_STROKE:
        break;
    }
    return 0;
}

static struct packet draw(uint8_t *bytes, size_t length, const struct pro_tev_image *image,
                          const struct pro_tev_command *command, int count)
{
    struct packet packet = begin(bytes, length, VECTOR_GRAPHICS);
    put_byte(&packet, false); /* what the user looks at stays shown */
    put_text(&packet, image->name);
    put_byte(&packet, false); /* the lines are not added to those that were drawn before */
    put_int(&packet, count);
    for (int i = 0; i < count; i++) {
        put_byte(&packet, (uint8_t)command[i].pen);
        put(&packet, command[i].argument, sizeof *command[i].argument * arguments_of(command[i].pen));
    }
    return packet;
}

uint8_t *pro_tev_draw(const struct pro_tev_image *image, const struct pro_tev_command *command, int count,
                      size_t *out_count)
{
    const struct packet measured = draw(NULL, 0, image, command, count);
    uint8_t *bytes = room_for(&measured, out_count);
    if (bytes) draw(bytes, measured.count, image, command, count);
    return bytes;
}
