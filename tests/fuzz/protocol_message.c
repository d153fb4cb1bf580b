/* Fuzzing of everything that a peer can send: bytes to frames to messages to tiles. As a test it changes a
 * valid stream at random, from a fixed seed. For libFuzzer see fuzz.h. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol.h"

enum { TILE = 8 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 1) return 0;
    size_t step = data[0] ? data[0] : PRO_CHUNK;
    struct pro_reader reader;
    enum pro_result result = PRO_MORE;
    pro_reader_init(&reader, PRO_MAX_TO_DAEMON);
    for (size_t at = 1; at < size && result == PRO_MORE;) {
        size_t count = size - at < step ? size - at : step;
        uint8_t *exact = malloc(count); /* exact size: a sanitizer notices any access beyond */
        if (!exact) abort();
        memcpy(exact, data + at, count);
        if (!pro_reader_add(&reader, exact, count)) abort();
        free(exact);
        at += count;
        char error[PRO_ERROR_SIZE] = "";
        Fovea__Message *message;
        while ((result = pro_reader_take(&reader, &message, error)) == PRO_MESSAGE) {
            float rgb[TILE * TILE * 3];
            if (message->body_case == FOVEA__MESSAGE__BODY_TILE)
                pro_decode(message->tile->encoding, message->tile->data.data, message->tile->data.len, TILE,
                           rgb);
            fovea__message__free_unpacked(message, NULL);
        }
        if ((result == PRO_BROKEN) != (*error != '\0')) abort();
    }
    pro_reader_finish(&reader);
    return 0;
}

#ifndef LIBFUZZER

/* Make a stream with one message of each of many kinds. Returns its length. */
static size_t valid_stream(uint8_t *out, size_t room)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    Fovea__Gaze gaze = FOVEA__GAZE__INIT;
    Fovea__Stats stats = FOVEA__STATS__INIT;
    Fovea__Tracker tracker = FOVEA__TRACKER__INIT;
    Fovea__Done done = FOVEA__DONE__INIT;
    Fovea__Move move = FOVEA__MOVE__INIT;
    Fovea__Tile tile = FOVEA__TILE__INIT;
    float numbers[4] = {0, 0, -1, 0}, rgb[TILE * TILE * 3];
    hello.client = "fuzz";
    hello.version = 1;
    gaze.n_direction = 3;
    gaze.n_head = 4;
    gaze.n_aim = 3;
    gaze.direction = gaze.head = gaze.aim = numbers;
    gaze.state = gaze.source = gaze.why = "fuzz";
    stats.samples_per_second = 1e6;
    stats.gaze_source = "fuzz";
    stats.tracker = &tracker;
    stats.samples = stats.rays = UINT64_MAX;
    stats.scene = stats.refused = "fuzz";
    done.text = "done";
    move.n_camera = done.n_camera = stats.n_camera = 3;
    move.camera = done.camera = stats.camera = numbers;
    for (int i = 0; i < TILE * TILE * 3; i++) rgb[i] = (float)(i % 10) / 10;
    struct {
        Fovea__Message__BodyCase kind;
        void *body;
    } messages[] = {
        {FOVEA__MESSAGE__BODY_HELLO, &hello}, {FOVEA__MESSAGE__BODY_GAZE, &gaze},
        {FOVEA__MESSAGE__BODY_STATS, &stats}, {FOVEA__MESSAGE__BODY_DONE, &done},
        {FOVEA__MESSAGE__BODY_MOVE, &move},   {FOVEA__MESSAGE__BODY_TILE, &tile},
        {FOVEA__MESSAGE__BODY_TILE, &tile},
    };
    size_t used = 0;
    tile.encoding = FOVEA__ENCODING__ENCODING_HALF_ZSTD;
    for (size_t i = 0; i < sizeof messages / sizeof *messages; i++) {
        Fovea__Message message = FOVEA__MESSAGE__INIT;
        size_t count;
        tile.data.data = pro_encode(tile.encoding, rgb, TILE, &tile.data.len);
        message.body_case = messages[i].kind;
        message.hello = messages[i].body; /* the members of the union are pointers */
        uint8_t *bytes = pro_pack(&message, 0, &count);
        if (!tile.data.data || !bytes || count > room - used) abort();
        memcpy(out + used, bytes, count);
        used += count;
        free(bytes);
        free(tile.data.data);
        if (message.body_case == FOVEA__MESSAGE__BODY_TILE) tile.encoding = FOVEA__ENCODING__ENCODING_JPEG;
    }
    return used;
}

static uint64_t noise(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 33;
}

int main(void)
{
    static uint8_t valid[16 << 10], input[16 << 10];
    uint64_t seed = 360;
    size_t length = valid_stream(valid, sizeof valid);
    for (int round = 0; round < 20000; round++) {
        size_t size = length + 1;
        input[0] = (uint8_t)noise(&seed);
        memcpy(input + 1, valid, length);
        for (uint64_t hits = noise(&seed) % 8; hits > 0; hits--) {
            size_t at = noise(&seed) % size;
            switch (noise(&seed) % 4) {
            case 0:
                input[at] ^= (uint8_t)(1 << noise(&seed) % 8);
                break;
            case 1:
                input[at] = (uint8_t)noise(&seed);
                break;
            case 2:
                size = at + 1;
                break;
            case 3:
                memmove(input + at, input + at / 2, size - at);
                break;
            }
        }
        LLVMFuzzerTestOneInput(input, size);
    }
    printf("20000 streams of up to %zu bytes\n", length + 1);
    return 0;
}

#endif
