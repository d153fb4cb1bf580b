/* The samples of a log, packed. A log may have tens of millions of samples. A struct trk_sample has room for
 * everything that any tracker measures, but a log fills only a few of its fields.
 *
 * A block holds up to ROWS consecutive samples. In a block, a field takes the same number of bits in every
 * row: as many as its largest remainder needs. The remainder of a sequence number, device time or delay is
 * its height above a line that has the slope from the first row to the last; the remainder of any other field
 * is its height above the lowest value. If all remainders of a field are 0, it takes no bits. A float is
 * treated as an integer with the same bits. A field that no sample of the block has is left out. The combined
 * gaze is left out too if trk_combine() computes the same values from the eyes; then reading a sample calls
 * trk_combine(). A sample comes out exactly as it went in, bit for bit, except that fields whose valid bit is
 * unset come out as 0.
 *
 * At most one block is open, as an array of samples: the last block while the log grows, or another block
 * while its samples are replaced. */
#include "log/samples.h"

#include "gaze.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS = 512 };

/* The value in row i is base + i * step + the column's bits in that row, modulo 2^64. */
struct column {
    uint64_t base, step;
    uint64_t mask;   /* 1s, as many as bits */
    uint16_t at;     /* of the column's first bit in a row */
    uint16_t bits;   /* number of bits: 0 to 64 */
    uint16_t offset; /* floats only: in struct trk_sample */
    uint16_t valid;  /* floats only: the TRK_* bit that marks rows with a value */
};

/* Every block begins with these columns; the columns of floats follow. DELAY is arrival time minus device
 * time; in most logs it is 0. */
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

struct head {
    uint32_t columns, row_bits;
    uint32_t combined; /* TRK_DIRECTION, TRK_ORIGIN: left out, because trk_combine() computes it */
};

struct block {
    struct head head;
    struct column column[]; /* then the rows, packed into 64-bit words from the lowest bit up */
};

struct trk_samples {
    struct block **blocks; /* NULL for the open block */
    size_t room;           /* of blocks */
    struct trk_sample *open;
    size_t open_index; /* of the open block; SIZE_MAX if none */
};

/* --- one block --- */

static uint64_t value_at(const struct block *block, int column, size_t row)
{
    const struct column *c = &block->column[column];
    const uint64_t *words = (const uint64_t *)&block->column[block->head.columns];
    const size_t at = row * block->head.row_bits + c->at;
    const unsigned skipped = at % 64;
    uint64_t rest = words[at / 64] >> skipped;
    if (skipped + c->bits > 64) rest |= words[at / 64 + 1] << (64 - skipped);
    return c->base + row * c->step + (rest & c->mask);
}

/* Compute these parts (bits) of the combined gaze of a sample. All its other fields are already set. */
static void combine(struct trk_sample *sample, uint32_t bits)
{
    const uint32_t valid = sample->valid;
    sample->valid &= ~bits;
    trk_combine(sample);
    sample->valid = valid;
    if (!(valid & TRK_DIRECTION)) memset(sample->direction, 0, sizeof sample->direction);
    if (!(valid & TRK_ORIGIN)) memset(sample->origin, 0, sizeof sample->origin);
}

static void unpack_row(const struct block *block, size_t row, struct trk_sample *out_sample)
{
    memset(out_sample, 0, sizeof *out_sample);
    out_sample->sequence = value_at(block, SEQUENCE, row);
    out_sample->device_ns = value_at(block, DEVICE, row);
    out_sample->arrival_ns = out_sample->device_ns + value_at(block, DELAY, row);
    out_sample->sensor_ns = value_at(block, SENSOR, row);
    out_sample->valid = (uint32_t)value_at(block, VALID, row);
    for (int i = WHOLE; i < (int)block->head.columns; i++) {
        if (!(out_sample->valid & block->column[i].valid)) continue;
        const uint32_t bits = (uint32_t)value_at(block, i, row);
        memcpy((char *)out_sample + block->column[i].offset, &bits, sizeof bits);
    }
    if (out_sample->valid & block->head.combined)
        combine(out_sample, out_sample->valid & block->head.combined);
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

/* Find the base and the step of a column, and the number of bits that its remainders need. */
static void fit(struct column *c, int column, const struct trk_sample *samples, size_t count)
{
    int64_t low = INT64_MAX, high = INT64_MIN;
    c->step = 0;
    if (column < VALID && count > 1) {
        const uint64_t rise = value_of(&samples[count - 1], column, 0) - value_of(&samples[0], column, 0);
        c->step = (uint64_t)((int64_t)rise / (int64_t)(count - 1));
    }
    for (size_t i = 0; i < count; i++) {
        if (column >= WHOLE && !(samples[i].valid & c->valid)) continue;
        const int64_t above = (int64_t)(value_of(&samples[i], column, c->offset) - i * c->step);
        if (above < low) low = above;
        if (above > high) high = above;
    }
    const uint64_t most = (uint64_t)high - (uint64_t)low;
    c->base = (uint64_t)low;
    c->bits = (uint16_t)(most ? 64 - __builtin_clzll(most) : 0);
    c->mask = c->bits ? UINT64_MAX >> (64 - c->bits) : 0;
}

/* The parts of the combined gaze that trk_combine() computes exactly from the eyes, in all samples that have
 * these parts. */
static uint32_t find_combined(const struct trk_sample *samples, size_t count)
{
    uint32_t combined = TRK_DIRECTION | TRK_ORIGIN;
    for (size_t i = 0; i < count && combined; i++) {
        const uint32_t there = samples[i].valid & combined;
        struct trk_sample made = samples[i];
        if (!there) continue;
        memset(made.direction, 0, sizeof made.direction);
        memset(made.origin, 0, sizeof made.origin);
        combine(&made, there);
        if ((there & TRK_DIRECTION) && memcmp(made.direction, samples[i].direction, sizeof made.direction))
            combined &= ~(uint32_t)TRK_DIRECTION;
        if ((there & TRK_ORIGIN) && memcmp(made.origin, samples[i].origin, sizeof made.origin))
            combined &= ~(uint32_t)TRK_ORIGIN;
    }
    return combined;
}

/* Find which columns these samples need, and the layout of a row. */
static void plan(struct head *head, struct column columns[MOST_COLUMNS], const struct trk_sample *samples,
                 size_t count)
{
    uint32_t seen = 0;
    for (size_t i = 0; i < count; i++) seen |= samples[i].valid;
    *head = (struct head){.columns = WHOLE, .combined = seen & find_combined(samples, count)};
    seen &= ~head->combined;
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++)
        for (unsigned k = 0; k < groups[g].floats && (seen & groups[g].bit); k++) {
            struct column *c = &columns[head->columns++];
            c->valid = (uint16_t)groups[g].bit;
            c->offset = (uint16_t)(groups[g].offset + k * sizeof(float));
        }
    for (uint32_t i = 0; i < head->columns; i++) {
        fit(&columns[i], (int)i, samples, count);
        columns[i].at = (uint16_t)head->row_bits;
        head->row_bits += columns[i].bits;
    }
}

/* NULL if memory runs out. */
static struct block *pack_block(const struct trk_sample *samples, size_t count)
{
    struct column columns[MOST_COLUMNS] = {0};
    struct head head;
    plan(&head, columns, samples, count);
    const size_t columns_size = head.columns * sizeof *columns;
    struct block *block =
        malloc(sizeof *block + columns_size + (count * head.row_bits / 64 + 1) * sizeof(uint64_t));
    if (!block) return NULL;
    block->head = head;
    memcpy(block->column, columns, columns_size);
    uint64_t *word = (uint64_t *)&block->column[head.columns], filling = 0;
    unsigned filled = 0; /* bits */
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < (int)head.columns; k++) {
            const struct column *c = &columns[k];
            if (!c->bits) continue;
            const uint64_t rest = (value_of(&samples[i], k, c->offset) - i * c->step - c->base) & c->mask;
            filling |= rest << filled;
            filled += c->bits;
            if (filled < 64) continue;
            filled -= 64;
            *word++ = filling;
            filling = filled ? rest >> (c->bits - filled) : 0;
        }
    *word = filling;
    return block;
}

/* --- all of them --- */

/* Pack the open block, if there is one. count is the number of samples in the log. False if memory runs out.
 */
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

/* Make room for a block with this index. False if memory runs out. */
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

/* Open the block of sample i, and return the sample's place. i may be one past the last sample. NULL if
 * memory runs out. */
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
        for (size_t i = WHOLE; block && i < block->head.columns; i++) seen |= block->column[i].valid;
        if (block) seen |= block->head.combined;
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
