/* The samples of a log, packed: a log may have tens of millions of them, a struct trk_sample has room for all
 * that any tracker measures, and a log fills a few of its fields.
 *
 * A block holds up to ROWS samples that follow each other. Every field has as many whole bytes in each row of
 * the block as the values there need: times and numbers beyond a straight line from the first row to the
 * last, all others beyond the lowest value, none where all are the same. A float is kept by its bits. Fields
 * that no sample of the block has are left out. So samples come out as they went in, bit for bit, but for
 * fields whose valid bit is unset: those come out as 0.
 *
 * One block at most is open, as an array of samples: the last one while a log grows, any other while its
 * samples are replaced. */
#include "log/samples.h"

#include <endian.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = 1024 };

/* Value of row i: base + i step + what is in the row's bytes under the mask, modulo 2^64. */
struct column {
    uint64_t base, step, mask;
    uint32_t bit;    /* of trk_sample.valid, that a row has this field by; floats only */
    uint16_t offset; /* of the float in struct trk_sample */
    uint16_t at;     /* of the first byte in a row */
};

/* The columns that every block has, before those of floats. DELAY is arrival time less device time, which
 * in most logs are the same. */
enum { SEQUENCE, DEVICE, DELAY, SENSOR, VALID, WHOLE };

static const struct group {
    uint32_t bit;
    uint16_t offset, floats;
} groups[] = {
#define GROUP(member, bit)                                                                                   \
    {                                                                                                        \
        bit, offsetof(struct trk_sample, member), sizeof((struct trk_sample *)0)->member / sizeof(float)     \
    }
#define EYE(index, SIDE)                                                                                     \
    GROUP(eye[index].direction, TRK_##SIDE##_DIRECTION), GROUP(eye[index].origin, TRK_##SIDE##_ORIGIN),      \
        GROUP(eye[index].openness, TRK_##SIDE##_OPENNESS), GROUP(eye[index].pupil_mm, TRK_##SIDE##_PUPIL)
    GROUP(direction, TRK_DIRECTION),
    GROUP(origin, TRK_ORIGIN),
    GROUP(head, TRK_HEAD),
    GROUP(screen, TRK_SCREEN),
    EYE(0, LEFT),
    EYE(1, RIGHT),
};
enum { MOST_COLUMNS = WHOLE + sizeof(struct trk_sample) / sizeof(float) };

struct block {
    size_t columns, row_size;
    struct column column[]; /* the rows follow, and 8 bytes for the last value to be read with */
};

struct trk_samples {
    struct block **blocks; /* the open one is NULL */
    size_t room;           /* of blocks */
    struct trk_sample *open;
    size_t open_index; /* of the open block; SIZE_MAX: none is */
};

/* --- one block ------------------------------------------------------------------------------------------ */

static uint64_t value_at(const struct block *block, int column, size_t row)
{
    const struct column *c = &block->column[column];
    const char *rows = (const char *)&block->column[block->columns];
    uint64_t rest;
    memcpy(&rest, rows + row * block->row_size + c->at, sizeof rest);
    return c->base + row * c->step + (le64toh(rest) & c->mask);
}

static void unpack_row(const struct block *block, size_t row, struct trk_sample *out_sample)
{
    memset(out_sample, 0, sizeof *out_sample);
    out_sample->sequence = value_at(block, SEQUENCE, row);
    out_sample->device_ns = value_at(block, DEVICE, row);
    out_sample->arrival_ns = out_sample->device_ns + value_at(block, DELAY, row);
    out_sample->sensor_ns = value_at(block, SENSOR, row);
    out_sample->valid = (uint32_t)value_at(block, VALID, row);
    for (int i = WHOLE; i < (int)block->columns; i++) {
        if (!(out_sample->valid & block->column[i].bit)) continue;
        const uint32_t bits = (uint32_t)value_at(block, i, row);
        memcpy((char *)out_sample + block->column[i].offset, &bits, sizeof bits);
    }
}

static uint64_t value_of(const struct trk_sample *sample, int column, size_t offset)
{
    uint32_t bits;
    switch (column) {
    case SEQUENCE:
        return sample->sequence;
    case DEVICE:
        return sample->device_ns;
    case DELAY:
        return sample->arrival_ns - sample->device_ns;
    case SENSOR:
        return sample->sensor_ns;
    case VALID:
        return sample->valid;
    default:
        memcpy(&bits, (const char *)sample + offset, sizeof bits);
        return bits;
    }
}

/* Find what a column's values need in a row; returns how many bytes. */
static unsigned fit(struct column *c, int column, const struct trk_sample *samples, size_t count)
{
    int64_t low = INT64_MAX, high = INT64_MIN;
    c->step = 0;
    if (column < VALID && count > 1) {
        const uint64_t rise = value_of(&samples[count - 1], column, 0) - value_of(&samples[0], column, 0);
        c->step = (uint64_t)((int64_t)rise / (int64_t)(count - 1));
    }
    for (size_t i = 0; i < count; i++) {
        if (column >= WHOLE && !(samples[i].valid & c->bit)) continue;
        const int64_t above = (int64_t)(value_of(&samples[i], column, c->offset) - i * c->step);
        if (above < low) low = above;
        if (above > high) high = above;
    }
    const uint64_t most = (uint64_t)high - (uint64_t)low;
    unsigned bytes = 0;
    while (bytes < sizeof most && most >> 8 * bytes) bytes++;
    c->base = (uint64_t)low;
    c->mask = bytes == sizeof most ? UINT64_MAX : (UINT64_C(1) << 8 * bytes) - 1;
    return bytes;
}

/* Returns how many columns these samples need. */
static size_t fit_all(struct column columns[MOST_COLUMNS], const struct trk_sample *samples, size_t count,
                      size_t *out_row_size)
{
    uint32_t seen = 0;
    size_t columns_used = WHOLE, size = 0;
    for (size_t i = 0; i < count; i++) seen |= samples[i].valid;
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++)
        for (unsigned k = 0; k < groups[g].floats && (seen & groups[g].bit); k++) {
            columns[columns_used].bit = groups[g].bit;
            columns[columns_used++].offset = (uint16_t)(groups[g].offset + k * sizeof(float));
        }
    for (size_t i = 0; i < columns_used; i++) {
        columns[i].at = (uint16_t)size;
        size += fit(&columns[i], (int)i, samples, count);
    }
    *out_row_size = size;
    return columns_used;
}

/* NULL when memory is short. */
static struct block *pack_block(const struct trk_sample *samples, size_t count)
{
    struct column columns[MOST_COLUMNS] = {0};
    size_t row_size, used = fit_all(columns, samples, count, &row_size);
    struct block *block =
        malloc(sizeof *block + used * sizeof *columns + count * row_size + sizeof(uint64_t));
    if (!block) return NULL;
    block->columns = used;
    block->row_size = row_size;
    memcpy(block->column, columns, used * sizeof *columns);
    char *row = (char *)&block->column[used];
    memset(row + count * row_size, 0, sizeof(uint64_t));
    /* In order, for the bytes of a value that are above its mask lie where the next one goes. */
    for (size_t i = 0; i < count; i++, row += row_size)
        for (int k = 0; k < (int)used; k++) {
            const struct column *c = &columns[k];
            if (!c->mask) continue;
            const uint64_t rest = value_of(&samples[i], k, c->offset) - i * c->step - c->base;
            const uint64_t bytes = htole64(rest & c->mask);
            memcpy(row + c->at, &bytes, sizeof bytes);
        }
    return block;
}

/* --- all of them ---------------------------------------------------------------------------------------- */

/* Pack the open block of count samples in all, if there is one. False when memory is short. */
static bool close_block(struct trk_samples *samples, size_t count)
{
    if (samples->open_index == SIZE_MAX) return true;
    const size_t left = count - samples->open_index * ROWS;
    struct block *block = pack_block(samples->open, left < ROWS ? left : ROWS);
    if (!block) return false;
    samples->blocks[samples->open_index] = block;
    samples->open_index = SIZE_MAX;
    return true;
}

/* Make room for a block of this index. False when memory is short. */
static bool grow(struct trk_samples *samples, size_t index)
{
    if (index < samples->room) return true;
    const size_t room = samples->room ? 2 * samples->room : 1;
    struct block **blocks = realloc(samples->blocks, room * sizeof(*blocks));
    if (!blocks) return false;
    memset(blocks + samples->room, 0, (room - samples->room) * sizeof(*blocks));
    samples->blocks = blocks;
    samples->room = room;
    return true;
}

/* Open the block with sample i, which may be the first after the last; NULL when memory is short. */
static struct trk_sample *open_at(struct trk_log *log, size_t i)
{
    const size_t index = i / ROWS;
    if (!log->samples) {
        log->samples = calloc(1, sizeof *log->samples);
        if (!log->samples) return NULL;
        log->samples->open_index = SIZE_MAX;
    }
    struct trk_samples *samples = log->samples;
    if (samples->open_index == index) return &samples->open[i % ROWS];
    if (!samples->open) samples->open = malloc(ROWS * sizeof *samples->open);
    if (!samples->open || !grow(samples, index) || !close_block(samples, log->count)) return NULL;
    for (size_t row = 0; row < ROWS && index * ROWS + row < log->count; row++)
        unpack_row(samples->blocks[index], row, &samples->open[row]);
    free(samples->blocks[index]);
    samples->blocks[index] = NULL;
    samples->open_index = index;
    return &samples->open[i % ROWS];
}

bool trk_samples_add(struct trk_log *log, const struct trk_sample *sample)
{
    if (!trk_samples_put(log, log->count, sample)) return false;
    log->count++;
    return true;
}

bool trk_samples_put(struct trk_log *log, size_t i, const struct trk_sample *sample)
{
    struct trk_sample *place = open_at(log, i);
    if (!place) return false;
    *place = *sample;
    return true;
}

bool trk_samples_pack(struct trk_log *log)
{
    struct trk_samples *samples = log->samples;
    if (!samples) return true;
    if (!close_block(samples, log->count)) return false;
    free(samples->open);
    samples->open = NULL;
    return true;
}

void trk_log_sample(const struct trk_log *log, size_t i, struct trk_sample *out_sample)
{
    const struct trk_samples *samples = log->samples;
    const struct block *block = samples->blocks[i / ROWS];
    if (block)
        unpack_row(block, i % ROWS, out_sample);
    else
        *out_sample = samples->open[i % ROWS];
}

uint64_t trk_log_time(const struct trk_log *log, size_t i)
{
    const struct trk_samples *samples = log->samples;
    const struct block *block = samples->blocks[i / ROWS];
    return block ? value_at(block, DEVICE, i % ROWS) : samples->open[i % ROWS].device_ns;
}

uint32_t trk_log_seen(const struct trk_log *log)
{
    const struct trk_samples *samples = log->samples;
    uint32_t seen = 0;
    for (size_t index = 0; index * ROWS < log->count; index++) {
        const struct block *block = samples->blocks[index];
        for (size_t i = WHOLE; block && i < block->columns; i++) seen |= block->column[i].bit;
        for (size_t i = 0; !block && i < ROWS && index * ROWS + i < log->count; i++)
            seen |= samples->open[i].valid;
    }
    return seen;
}

void trk_samples_destroy(struct trk_samples *samples)
{
    if (!samples) return;
    for (size_t i = 0; i < samples->room; i++) free(samples->blocks[i]);
    free(samples->blocks);
    free(samples->open);
    free(samples);
}
