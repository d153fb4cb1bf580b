/* A viewer that takes pictures by tev's protocol, as strict as can be: whatever is not exactly as the protocol
 * has it ends it with status 1 and a line that says what. fake_tev PORT WAY...
 *
 *   hold FILE   take one connection to its end, and write what the picture is then to FILE
 *   deaf        take connections, and read nothing
 *   slam N      close so many connections as soon as they come
 *   talk        send something
 *
 * It tells what happens, one line each: "listens"; "created WIDTHxHEIGHT CHANNEL..."; "tiles N" after every
 * eighth tile; "whole" once every pixel has come; "mark X Y" where the last line over the picture begins;
 * "closed". */
#include <arpa/inet.h>
#include <math.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { MOST_CHANNELS = 64, NAME_SIZE = 64, MOST_BYTES = 1 << 30 };

/* What the viewer shows. */
struct picture {
    char name[512];
    int32_t width, height, channels;
    char channel[MOST_CHANNELS][NAME_SIZE];
    float *value; /* one channel after the other */
    uint8_t *came;
    size_t missing; /* pixels that have not come */
    unsigned long tiles, marks;
    float mark[2];
};

static void fail(const char *what)
{
    fprintf(stderr, "fake_tev: %s\n", what);
    exit(1);
}

static void check(bool good, const char *what)
{
    if (!good) fail(what);
}

/* --- the fields of a packet --- */

struct reader {
    const uint8_t *at, *end;
};

static void take(struct reader *reader, void *out, size_t size)
{
    check((size_t)(reader->end - reader->at) >= size, "a packet ends within a field");
    memcpy(out, reader->at, size);
    reader->at += size;
}

static uint8_t take_byte(struct reader *reader)
{
    uint8_t value;

    take(reader, &value, sizeof(value));
    return value;
}

static bool take_bool(struct reader *reader)
{
    const uint8_t value = take_byte(reader);

    check(value <= 1, "a bool is neither 0 nor 1");
    return value;
}

static int32_t take_int(struct reader *reader)
{
    int32_t value;

    take(reader, &value, sizeof(value));
    return value;
}

static float take_float(struct reader *reader)
{
    float value;

    take(reader, &value, sizeof(value));
    check(isfinite(value), "a value is not finite");
    return value;
}

static void take_text(struct reader *reader, char *out, size_t size)
{
    size_t length = 0;

    do check(length < size, "a text is too long");
    while ((out[length++] = (char)take_byte(reader)));
    check(length > 1, "a text is empty");
}

/* The name of the picture that was created. */
static void take_name(struct reader *reader, const struct picture *picture)
{
    char name[sizeof(picture->name)];

    take_text(reader, name, sizeof(name));
    check(picture->value, "the picture was not created");
    check(!strcmp(name, picture->name), "another picture's name");
}

/* --- packets --- */

static int find(const struct picture *picture, int channels, const char *name)
{
    for (int i = 0; i < channels; i++)
        if (!strcmp(picture->channel[i], name)) return i;
    return -1;
}

static void create(struct reader *reader, struct picture *picture)
{
    size_t pixels;

    check(!picture->value, "the picture is created twice");
    take_bool(reader);
    take_text(reader, picture->name, sizeof(picture->name));
    picture->width = take_int(reader);
    picture->height = take_int(reader);
    picture->channels = take_int(reader);
    check(picture->width > 0 && picture->height > 0 && picture->width <= 32768 && picture->height <= 32768,
          "a size out of range");
    check(picture->channels > 0 && picture->channels <= MOST_CHANNELS, "a number of channels out of range");
    printf("created %dx%d", picture->width, picture->height);
    for (int i = 0; i < picture->channels; i++) {
        take_text(reader, picture->channel[i], NAME_SIZE);
        check(find(picture, i, picture->channel[i]) < 0, "two channels have the same name");
        printf(" %s", picture->channel[i]);
    }
    printf(" '%s'\n", picture->name);
    pixels = (size_t)picture->width * (size_t)picture->height;
    picture->value = calloc(pixels * (size_t)picture->channels, sizeof(*picture->value));
    picture->came = calloc(pixels, 1);
    check(picture->value && picture->came, "out of memory");
    picture->missing = pixels;
}

static void put(struct picture *picture, int channel, int x, int y, float value)
{
    const size_t at = (size_t)y * (size_t)picture->width + (size_t)x,
                 pixels = (size_t)picture->width * (size_t)picture->height;

    check(isfinite(value), "a value is not finite");
    picture->value[(size_t)channel * pixels + at] = value;
    picture->missing -= !picture->came[at];
    picture->came[at] = 1;
}

static void update(struct reader *reader, struct picture *picture)
{
    const size_t missing = picture->missing;
    int channel[MOST_CHANNELS];
    int64_t offset[MOST_CHANNELS], stride[MOST_CHANNELS], pixels, last = 0;
    int32_t channels, x, y, width, height;
    char name[NAME_SIZE];
    uint64_t used = 0;

    check(!take_bool(reader), "an update grabs the focus");
    take_name(reader, picture);
    channels = take_int(reader);
    check(channels == picture->channels, "an update has not all channels");
    for (int i = 0; i < channels; i++) {
        take_text(reader, name, sizeof(name));
        channel[i] = find(picture, picture->channels, name);
        check(channel[i] >= 0, "there is no such channel");
        check(!(used >> channel[i] & 1), "a channel is updated twice");
        used |= (uint64_t)1 << channel[i];
    }
    x = take_int(reader);
    y = take_int(reader);
    width = take_int(reader);
    height = take_int(reader);
    check(x >= 0 && y >= 0 && width > 0 && height > 0 && width <= picture->width - x &&
              height <= picture->height - y,
          "a tile is not wholly inside the picture");
    pixels = (int64_t)width * height;
    take(reader, offset, (size_t)channels * sizeof(*offset));
    take(reader, stride, (size_t)channels * sizeof(*stride));
    for (int i = 0; i < channels; i++) {
        check(offset[i] >= 0 && offset[i] < MOST_BYTES && stride[i] > 0 && stride[i] < 4096,
              "an offset or a stride is out of range");
        if (offset[i] + (pixels - 1) * stride[i] > last) last = offset[i] + (pixels - 1) * stride[i];
    }
    check((uint64_t)(reader->end - reader->at) == ((uint64_t)last + 1) * sizeof(float),
          "the values are not as many as they should be");
    for (int i = 0; i < channels; i++)
        for (int64_t k = 0; k < pixels; k++) {
            float value;

            memcpy(&value, reader->at + sizeof(value) * (size_t)(offset[i] + k * stride[i]), sizeof(value));
            put(picture, channel[i], x + (int)(k % width), y + (int)(k / width), value);
        }
    reader->at = reader->end;
    picture->tiles++;
    if (picture->tiles % 8 == 0) printf("tiles %lu\n", picture->tiles);
    if (missing > 0 && picture->missing == 0) printf("whole\n");
}

/* Commands by their number: how many floats follow; -1: none is known to every viewer. */
static int floats_of(uint8_t command)
{
    switch (command) {
    case 5: /* Stroke */
    case 6: /* BeginPath */
        return 0;
    case 10: /* MoveTo */
    case 11: /* LineTo */
        return 2;
    case 15: /* Circle */
        return 3;
    case 4: /* StrokeColor */
        return 4;
    default:
        return -1;
    }
}

static void draw(struct reader *reader, struct picture *picture)
{
    bool path = false, point = false, stroked = false;
    float mark[2] = {-1, -1};
    int32_t commands;

    check(!take_bool(reader), "lines grab the focus");
    take_name(reader, picture);
    check(!take_bool(reader), "lines are added to those that were there");
    commands = take_int(reader);
    check(commands > 0 && commands <= 4096, "a number of commands out of range");
    for (int32_t i = 0; i < commands; i++) {
        const uint8_t command = take_byte(reader);
        const int floats = floats_of(command);
        float argument[4];

        check(floats >= 0, "a command that is not known to every viewer");
        for (int k = 0; k < floats; k++) argument[k] = take_float(reader);
        check(command == 6 || command == 4 || path, "a command outside a path");
        check(command != 11 || point, "a line from nowhere");
        if (floats == 2)
            check(argument[0] >= 0 && argument[0] <= (float)picture->width && argument[1] >= 0 &&
                      argument[1] <= (float)picture->height,
                  "a point outside the picture");
        if (command == 10) memcpy(mark, argument, sizeof(mark));
        path |= command == 6;
        point |= command == 10;
        stroked |= command == 5 && point;
    }
    check(stroked, "nothing is drawn");
    picture->marks++;
    if (memcmp(mark, picture->mark, sizeof(mark)))
        printf("mark %.1f %.1f\n", (double)mark[0], (double)mark[1]);
    memcpy(picture->mark, mark, sizeof(mark));
}

static void take_packet(const uint8_t *bytes, size_t length, struct picture *picture)
{
    struct reader reader = {bytes + 4, bytes + length};

    switch (take_byte(&reader)) {
    case 4:
        create(&reader, picture);
        break;
    case 6:
        update(&reader, picture);
        break;
    case 8:
        draw(&reader, picture);
        break;
    default:
        fail("a packet of another kind");
    }
    check(reader.at == reader.end, "a packet goes on after its last field");
}

/* --- connections --- */

static int listen_at(int port)
{
    struct sockaddr_in name = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int fd = socket(AF_INET, SOCK_STREAM, 0);

    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &(int){1}, sizeof(int));
    if (fd < 0 || bind(fd, (struct sockaddr *)&name, sizeof(name)) || listen(fd, 5)) {
        perror("fake_tev");
        exit(2);
    }
    printf("listens\n");
    return fd;
}

static double seconds_now(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void write_picture(const struct picture *picture, const char *path)
{
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    FILE *file = fopen(path, "w");

    check(file, "the picture cannot be written");
    fprintf(file, "%d %d %d\n", picture->width, picture->height, picture->channels);
    for (int i = 0; i < picture->channels; i++) fprintf(file, "%s\n", picture->channel[i]);
    check(fwrite(picture->value, sizeof(float), pixels * (size_t)picture->channels, file) ==
                  pixels * (size_t)picture->channels &&
              !fclose(file),
          "the picture cannot be written");
}

static void hold(int fd, const char *path)
{
    static struct picture picture;
    size_t held = 0, size = 1 << 20;
    uint8_t *bytes = malloc(size);
    const double began = seconds_now();
    ssize_t came;

    check(bytes, "out of memory");
    while ((came = recv(fd, bytes + held, size - held, 0)) > 0) {
        size_t used = 0;
        uint32_t length = 0;

        held += (size_t)came;
        while (held - used >= sizeof(length)) {
            memcpy(&length, bytes + used, sizeof(length));
            check(length > 4 && length <= MOST_BYTES, "a length out of range");
            if (length > held - used) break;
            take_packet(bytes + used, length, &picture);
            used += length;
        }
        held -= used;
        memmove(bytes, bytes + used, held);
        if (length > size && !(bytes = realloc(bytes, size = length))) fail("out of memory");
    }
    printf("closed\n");
    check(came == 0 && held == 0, "the connection ends within a packet");
    check(picture.value, "there is no picture");
    /* At most 20 a second; a second of them may have waited until they were read. */
    check((double)picture.marks <= 20 * (seconds_now() - began) + 22, "too many marks");
    free(bytes);
    write_picture(&picture, path);
}

int main(int argc, char **argv)
{
    int listener, fd = -1;
    const char *way = argc > 2 ? argv[2] : "";

    if (argc < 3) return 2;
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* it ends with the test */
    setvbuf(stdout, NULL, _IOLBF, 0);
    listener = listen_at(atoi(argv[1]));
    if (!strcmp(way, "deaf")) { /* what comes is held by as little as possible */
        setsockopt(listener, SOL_SOCKET, SO_RCVBUF, &(int){4096}, sizeof(int));
        for (;;) accept(listener, NULL, NULL);
    }
    for (int i = 0; !strcmp(way, "slam") && i < atoi(argv[3]); i++) {
        fd = accept(listener, NULL, NULL);
        close(fd);
    }
    if (!strcmp(way, "hold") || !strcmp(way, "talk")) fd = accept(listener, NULL, NULL);
    if (!strcmp(way, "hold")) hold(fd, argv[3]);
    if (!strcmp(way, "talk")) {
        char bytes[4096];

        check(send(fd, "SSH-2.0-fake\r\n", 14, MSG_NOSIGNAL) == 14, "nothing can be said");
        while (recv(fd, bytes, sizeof(bytes), 0) > 0) continue;
    }
    return fd < 0;
}
