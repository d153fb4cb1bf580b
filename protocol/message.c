/* message.c: messages to bytes and back, whatever wraps and carries them. */
#include "internal.h"

#include <stdlib.h>

/* Besides a copy of its bytes, unpacking a sensible message needs its structures, and protobuf-c's records of
 * more than 16 fields. A message of millions of unknown fields of two bytes would need some 40 times its
 * length. */
enum { UNPACK_SLACK = 16 << 10 };

static void *budget_alloc(void *data, size_t size)
{
    size_t *left = data;
    if (size > *left) return NULL;
    *left -= size;
    return malloc(size);
}

static void budget_free(void *data, void *block)
{
    (void)data;
    free(block);
}

Fovea__Message *pro_unpack_message(const uint8_t *bytes, size_t count, char out_error[PRO_ERROR_SIZE])
{
    size_t budget = count + UNPACK_SLACK;
    ProtobufCAllocator allocator = {budget_alloc, budget_free, &budget};
    Fovea__Message *message = fovea__message__unpack(&allocator, count, bytes);
    if (!message) {
        pro_fail(out_error, "%zu bytes that are not a message", count);
        return NULL;
    }
    /* The members of the union are all pointers to messages. */
    if (message->body_case == FOVEA__MESSAGE__BODY__NOT_SET || !message->hello) {
        fovea__message__free_unpacked(message, NULL);
        pro_fail(out_error, "a message with no known body");
        return NULL;
    }
    return message;
}

uint8_t *pro_pack_message(const Fovea__Message *message, size_t headroom, size_t *out_count)
{
    size_t length = fovea__message__get_packed_size(message);
    if (length > PRO_MAX_TO_CLIENT) return NULL;
    uint8_t *bytes = malloc(headroom + length);
    if (!bytes) return NULL;
    fovea__message__pack(message, bytes + headroom);
    *out_count = length;
    return bytes;
}
