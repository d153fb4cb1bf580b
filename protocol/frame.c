/* frame.c: frames to bytes and back. A frame is a 4-byte big-endian length and that many bytes of one
 * Message.
 *
 * Nothing here knows of sockets. A peer costs memory in proportion to what it has really sent: the buffer
 * grows with the bytes that came, not with the length that was announced. */
#include "internal.h"

#include <endian.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_SIZE = 4 << 10 };

void pro_reader_init(struct pro_reader *reader, size_t limit)
{
    *reader = (struct pro_reader){.limit = limit};
}

void pro_reader_finish(struct pro_reader *reader)
{
    free(reader->bytes);
    pro_reader_init(reader, reader->limit);
}

bool pro_reader_add(struct pro_reader *reader, const void *bytes, size_t count)
{
    size_t most = reader->limit + PRO_PREFIX + PRO_CHUNK;
    if (count > most - reader->used) return false;
    if (count == 0) return true;

    if (reader->start > 0 && count > reader->size - reader->start - reader->used) {
        memmove(reader->bytes, reader->bytes + reader->start, reader->used);
        reader->start = 0;
    }
    size_t needed = reader->used + count;
    if (needed > reader->size) {
        size_t size = reader->size < FIRST_SIZE / 2 ? FIRST_SIZE : 2 * reader->size;
        if (size > most) size = most;
        if (size < needed) size = needed;
        uint8_t *grown = realloc(reader->bytes, size);
        if (!grown) return false;
        reader->bytes = grown;
        reader->size = size;
    }
    memcpy(reader->bytes + reader->start + reader->used, bytes, count);
    reader->used += count;
    return true;
}

static uint32_t frame_length(const struct pro_reader *reader)
{
    uint32_t length;
    memcpy(&length, reader->bytes + reader->start, PRO_PREFIX);
    return be32toh(length);
}

bool pro_reader_ready(const struct pro_reader *reader)
{
    return reader->used >= PRO_PREFIX && reader->used - PRO_PREFIX >= frame_length(reader);
}

enum pro_result pro_reader_take(struct pro_reader *reader, Fovea__Message **out_message,
                                char out_error[PRO_ERROR_SIZE])
{
    *out_message = NULL;
    if (reader->used < PRO_PREFIX) return PRO_MORE;
    uint32_t length = frame_length(reader);
    if (length == 0) {
        pro_fail(out_error, "a message of length zero");
        return PRO_BROKEN;
    }
    if (length > reader->limit) {
        pro_fail(out_error, "a message of %u bytes, where %zu is the limit", length, reader->limit);
        return PRO_BROKEN;
    }
    if (reader->used - PRO_PREFIX < length) return PRO_MORE;

    Fovea__Message *message =
        pro_unpack_message(reader->bytes + reader->start + PRO_PREFIX, length, out_error);
    if (!message) return PRO_BROKEN;
    reader->start += PRO_PREFIX + length;
    reader->used -= PRO_PREFIX + length;
    if (reader->used == 0) reader->start = 0;
    *out_message = message;
    return PRO_MESSAGE;
}

void pro_put_length(uint8_t out_prefix[PRO_PREFIX], size_t count)
{
    uint32_t length = htobe32((uint32_t)count);
    memcpy(out_prefix, &length, PRO_PREFIX);
}

uint8_t *pro_pack(const Fovea__Message *message, size_t headroom, size_t *out_count)
{
    uint8_t *bytes = pro_pack_message(message, headroom + PRO_PREFIX, out_count);
    if (!bytes) return NULL;
    pro_put_length(bytes + headroom, *out_count);
    *out_count += PRO_PREFIX;
    return bytes;
}
