/* Frames: messages come out as they went in, however their bytes are cut up; bytes that are no message are
 * refused at once and at little cost.
 *
 * Linked with --wrap=malloc and --wrap=realloc, to count what the protocol allocates. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "protocol.h"

static size_t allocated;

void *__real_malloc(size_t size);
void *__real_realloc(void *block, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_realloc(void *block, size_t size);

void *__wrap_malloc(size_t size)
{
    allocated += size;
    return __real_malloc(size);
}

void *__wrap_realloc(void *block, size_t size)
{
    allocated += size;
    return __real_realloc(block, size);
}

/* SplitMix64 (Steele 2014). */
static uint64_t noise(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
}

static uint8_t *pack_tile(uint64_t serial, size_t data, size_t *out_count)
{
    Fovea__Tile tile = FOVEA__TILE__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    tile.serial = serial;
    tile.level = 3;
    tile.error = 0.25f;
    tile.settled = true;
    tile.aimed_ns = UINT64_MAX;
    tile.data.len = data;
    tile.data.data = malloc(data + 1);
    assert_non_null(tile.data.data);
    for (size_t i = 0; i < data; i++) tile.data.data[i] = (uint8_t)(serial + i);
    message.body_case = FOVEA__MESSAGE__BODY_TILE;
    message.tile = &tile;
    uint8_t *bytes = pro_pack(&message, 0, out_count);
    assert_non_null(bytes);
    free(tile.data.data);
    return bytes;
}

static void assert_tile(const Fovea__Message *message, uint64_t serial, size_t data)
{
    assert_int_equal(message->body_case, FOVEA__MESSAGE__BODY_TILE);
    assert_int_equal(message->tile->serial, serial);
    assert_int_equal(message->tile->level, 3);
    assert_true(message->tile->error == 0.25f);
    assert_true(message->tile->settled);
    assert_true(message->tile->aimed_ns == UINT64_MAX);
    assert_int_equal(message->tile->data.len, data);
    for (size_t i = 0; i < data; i++) assert_int_equal(message->tile->data.data[i], (uint8_t)(serial + i));
}

static void byte_by_byte(void **state)
{
    (void)state;
    size_t count;
    uint8_t *bytes = pack_tile(7, 300, &count);
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message;
    pro_reader_init(&reader, PRO_MAX_TO_CLIENT);
    for (int round = 0; round < 3; round++) {
        for (size_t i = 0; i < count; i++) {
            assert_int_equal(pro_reader_take(&reader, &message, error), PRO_MORE);
            assert_null(message);
            assert_true(pro_reader_add(&reader, bytes + i, 1));
        }
        assert_int_equal(pro_reader_take(&reader, &message, error), PRO_MESSAGE);
        assert_tile(message, 7, 300);
        fovea__message__free_unpacked(message, NULL);
    }
    assert_int_equal(pro_reader_take(&reader, &message, error), PRO_MORE);
    pro_reader_finish(&reader);
    free(bytes);
}

static void many_in_pieces(void **state)
{
    (void)state;
    enum { MESSAGES = 40 };
    size_t total = 0;
    uint8_t *stream = NULL;
    for (unsigned i = 0; i < MESSAGES; i++) {
        size_t count;
        uint8_t *bytes = pack_tile(i, 37 * i * i, &count);
        stream = realloc(stream, total + count);
        assert_non_null(stream);
        memcpy(stream + total, bytes, count);
        total += count;
        free(bytes);
    }
    size_t pieces[] = {3, 1000, 4096, 30011, PRO_CHUNK};
    for (size_t p = 0; p < sizeof pieces / sizeof *pieces; p++) {
        struct pro_reader reader;
        char error[PRO_ERROR_SIZE];
        Fovea__Message *message;
        unsigned got = 0;
        pro_reader_init(&reader, PRO_MAX_TO_DAEMON);
        for (size_t at = 0; at < total;) {
            size_t count = total - at < pieces[p] ? total - at : pieces[p];
            assert_true(pro_reader_add(&reader, stream + at, count));
            assert_true(reader.size <= reader.limit + 4 + PRO_CHUNK);
            at += count;
            while (pro_reader_take(&reader, &message, error) == PRO_MESSAGE) {
                assert_tile(message, got, 37 * got * got);
                fovea__message__free_unpacked(message, NULL);
                got++;
            }
        }
        assert_int_equal(got, MESSAGES);
        assert_int_equal(reader.used, 0);
        pro_reader_finish(&reader);
    }
    free(stream);
}

static void headroom(void **state)
{
    (void)state;
    Fovea__Ping ping = FOVEA__PING__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    ping.client_ns = 5;
    message.body_case = FOVEA__MESSAGE__BODY_PING;
    message.ping = &ping;
    size_t plain, shifted;
    uint8_t *a = pro_pack(&message, 0, &plain), *b = pro_pack(&message, 32, &shifted);
    const uint8_t wire[] = {0, 0, 0, 4, 0x3a, 2, 8, 5}; /* length; field 7, 2 bytes; field 1 */
    assert_int_equal(plain, sizeof wire);
    assert_int_equal(shifted, plain);
    assert_memory_equal(a, wire, sizeof wire);
    assert_memory_equal(b + 32, wire, sizeof wire);
    /* The message packed alone, behind its length, makes the same frame. */
    uint8_t *alone = pro_pack_message(&message, 32, &shifted), frame[sizeof wire];
    assert_int_equal(PRO_PREFIX + shifted, sizeof wire);
    pro_put_length(frame, shifted);
    memcpy(frame + PRO_PREFIX, alone + 32, shifted);
    assert_memory_equal(frame, wire, sizeof wire);
    char error[PRO_ERROR_SIZE] = "";
    Fovea__Message *back = pro_unpack_message(alone + 32, shifted, error);
    assert_non_null(back);
    assert_int_equal(back->body_case, FOVEA__MESSAGE__BODY_PING);
    assert_int_equal(back->ping->client_ns, 5);
    fovea__message__free_unpacked(back, NULL);
    assert_null(pro_unpack_message(alone + 32, shifted - 1, error));
    assert_string_equal(error, "3 bytes that are not a message");
    assert_null(pro_unpack_message(alone, 0, error));
    assert_string_equal(error, "a message with no known body");
    free(a);
    free(b);
    free(alone);
}

static void too_long_to_pack(void **state)
{
    (void)state;
    Fovea__Tile tile = FOVEA__TILE__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    tile.data.len = PRO_MAX_TO_CLIENT;
    tile.data.data = calloc(1, PRO_MAX_TO_CLIENT);
    message.body_case = FOVEA__MESSAGE__BODY_TILE;
    message.tile = &tile;
    size_t count;
    assert_null(pro_pack(&message, 0, &count));
    free(tile.data.data);
}

static void assert_broken(size_t limit, const void *bytes, size_t count, const char *expected)
{
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE] = "";
    Fovea__Message *message;
    pro_reader_init(&reader, limit);
    assert_true(pro_reader_add(&reader, bytes, count));
    assert_int_equal(pro_reader_take(&reader, &message, error), PRO_BROKEN);
    assert_null(message);
    assert_string_equal(error, expected);
    assert_int_equal(pro_reader_take(&reader, &message, error), PRO_BROKEN);
    pro_reader_finish(&reader);
}

static void refused(void **state)
{
    (void)state;
    assert_broken(PRO_MAX_TO_DAEMON, "\0\0\0\0", 4, "a message of length zero");
    assert_broken(PRO_MAX_TO_DAEMON, "\x80\0\0\0", 4,
                  "a message of 2147483648 bytes, where 65536 is the limit");
    assert_broken(PRO_MAX_TO_CLIENT, "\xff\xff\xff\xff", 4,
                  "a message of 4294967295 bytes, where 8388608 is the limit");
    assert_broken(PRO_MAX_TO_DAEMON, "\0\1\0\1", 4, "a message of 65537 bytes, where 65536 is the limit");
    assert_broken(PRO_MAX_TO_DAEMON, "\0\0\0\2\x3a\5", 6,
                  "2 bytes that are not a message"); /* the Ping is longer than the frame */
    assert_broken(PRO_MAX_TO_DAEMON, "\0\0\0\2\x38\5", 6,
                  "2 bytes that are not a message"); /* the Ping is a number */
    assert_broken(PRO_MAX_TO_DAEMON, "\0\0\0\3\xf8\3\1", 7, "a message with no known body"); /* field 63 */
}

static void limit_is_allowed(void **state)
{
    (void)state;
    size_t count, whole;
    free(pack_tile(1, 60000, &count));
    size_t data = 60000 + 4 + PRO_MAX_TO_DAEMON - count;
    uint8_t *bytes = pack_tile(1, data, &whole);
    assert_int_equal(whole, 4 + PRO_MAX_TO_DAEMON);
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message;
    pro_reader_init(&reader, PRO_MAX_TO_DAEMON);
    assert_true(pro_reader_add(&reader, bytes, whole));
    assert_int_equal(pro_reader_take(&reader, &message, error), PRO_MESSAGE);
    assert_tile(message, 1, data);
    fovea__message__free_unpacked(message, NULL);
    pro_reader_finish(&reader);
    free(bytes);
}

/* A peer that announces much and sends little costs little memory. A peer whose messages nobody takes is
 * stopped. */
static void memory_follows_bytes(void **state)
{
    (void)state;
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE];
    Fovea__Message *message;
    static const uint8_t chunk[PRO_CHUNK];
    pro_reader_init(&reader, PRO_MAX_TO_CLIENT);
    assert_true(pro_reader_add(&reader, "\0\x7f\xff\xff", 4));
    assert_int_equal(pro_reader_take(&reader, &message, error), PRO_MORE);
    assert_true(reader.size <= 4096);
    pro_reader_finish(&reader);

    pro_reader_init(&reader, PRO_MAX_TO_DAEMON);
    assert_true(pro_reader_add(&reader, chunk, PRO_CHUNK));
    assert_true(pro_reader_add(&reader, chunk, PRO_CHUNK));
    assert_false(pro_reader_add(&reader, chunk, PRO_CHUNK));
    assert_false(pro_reader_add(&reader, chunk, SIZE_MAX));
    assert_true(reader.size <= PRO_MAX_TO_DAEMON + 4 + PRO_CHUNK);
    pro_reader_finish(&reader);
}

/* Take all messages out of the bytes, and return how many there were. */
static unsigned take_all(const uint8_t *bytes, size_t count, size_t limit)
{
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE];
    unsigned messages = 0;
    pro_reader_init(&reader, limit);
    assert_true(pro_reader_add(&reader, bytes, count));
    for (;;) {
        Fovea__Message *message;
        allocated = 0;
        enum pro_result result = pro_reader_take(&reader, &message, error);
        assert_true(allocated <= count + (16 << 10));
        if (result != PRO_MESSAGE) {
            assert_null(message);
            if (result == PRO_BROKEN) assert_true(*error && !strchr(error, '\n'));
            break;
        }
        messages++;
        fovea__message__free_unpacked(message, NULL);
    }
    pro_reader_finish(&reader);
    return messages;
}

/* Frames for which protobuf-c would allocate many times their length. */
static void greedy_frames(void **state)
{
    (void)state;
    enum { LENGTH = 60000 };
    static const char *const units[] = {
        "\xf8\3\1",     /* an unknown field, repeated: protobuf-c keeps every one */
        "\x8a\1\0",     /* an empty Tile, repeated: all but the last are freed */
        "\x92\1\2\x12", /* a Gaze whose direction is cut off */
        "\x3a\0",       /* an empty Ping */
    };
    static const size_t sizes[] = {3, 3, 4, 2};
    uint8_t *bytes = malloc(4 + LENGTH);
    for (size_t u = 0; u < sizeof units / sizeof *units; u++) {
        memcpy(bytes, (uint8_t[]){0, 0, LENGTH >> 8, LENGTH & 255}, 4);
        for (size_t i = 0; i < LENGTH; i++) bytes[4 + i] = (uint8_t)units[u][i % sizes[u]];
        assert_int_equal(take_all(bytes, 4 + LENGTH, PRO_MAX_TO_DAEMON), 0);
    }
    /* One Gaze whose direction has as many floats as fit is honest: it takes no more memory than its bytes.
     */
    size_t floats = (LENGTH - 20) / 4 * 4, gaze = floats + 4;
    memset(bytes, 0, 4 + LENGTH);
    size_t length = gaze + 5;
    memcpy(bytes, (uint8_t[]){0, 0, (uint8_t)(length >> 8), (uint8_t)length}, 4);
    memcpy(bytes + 4,
           (uint8_t[]){0x92, 1, (uint8_t)(gaze | 128), (uint8_t)(gaze >> 7 | 128), (uint8_t)(gaze >> 14)}, 5);
    memcpy(bytes + 9,
           (uint8_t[]){0x12, (uint8_t)(floats | 128), (uint8_t)(floats >> 7 | 128), (uint8_t)(floats >> 14)},
           4);
    assert_int_equal(take_all(bytes, 4 + length, PRO_MAX_TO_DAEMON), 1);
    free(bytes);
}

static void noise_is_survived(void **state)
{
    (void)state;
    uint64_t seed = 20240229;
    size_t valid;
    uint8_t *tile = pack_tile(9, 64, &valid);
    unsigned messages = 0;
    for (int i = 0; i < 30000; i++) {
        size_t count = 1 + noise(&seed) % 200, prefix = i % 3 == 0 ? 0 : 4;
        uint8_t *bytes = malloc(prefix + count); /* exact size: a sanitizer notices any access beyond */
        for (size_t b = 0; b < count; b++) bytes[prefix + b] = (uint8_t)noise(&seed);
        if (prefix) memcpy(bytes, (uint8_t[]){0, 0, 0, (uint8_t)count}, 4);
        if (i % 3 == 2 && count >= valid - 4) { /* a valid message with a few bytes changed */
            memcpy(bytes, tile, valid);
            for (int hit = 0; hit < 3; hit++) bytes[4 + noise(&seed) % (valid - 4)] = (uint8_t)noise(&seed);
            count = valid - 4;
        }
        messages += take_all(bytes, prefix + count, PRO_MAX_TO_DAEMON);
        free(bytes);
    }
    assert_true(messages > 1000); /* proves that the noise reached the parser */
    free(tile);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(byte_by_byte),
        cmocka_unit_test(many_in_pieces),
        cmocka_unit_test(headroom),
        cmocka_unit_test(too_long_to_pack),
        cmocka_unit_test(refused),
        cmocka_unit_test(limit_is_allowed),
        cmocka_unit_test(memory_follows_bytes),
        cmocka_unit_test(greedy_frames),
        cmocka_unit_test(noise_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
