/* The samples of a log, packed. A log may have tens of millions of them; a struct trk_sample has room for
 * everything that any tracker measures, and a log fills only a few of its fields.
 *
 * A block holds up to ROWS consecutive samples. In a block a field takes the same number of bits in every
 * row, as many as its largest remainder needs. The remainder of a sequence number, device time or delay is
 * its height above a line with the slope from the first row to the last; the remainder of any other field is
 * its height above the lowest value. A field whose remainders are all 0 takes no bits. A float is kept as its
 * bits. Fields that no sample of the block has are left out. So is the combined gaze where trk_combine()
 * makes the same from the eyes; reading a sample then calls trk_combine(). Samples come out as they went in,
 * bit for bit; only fields whose valid bit is unset come out as 0.
 *
 * At most one block is open, as an array of samples: the last one while the log grows, or another one while
 * its samples are replaced. */
#include "log/samples.h"

#include "gaze.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS = 512 };

/* Value of row i: base + i step + what is in the row's bits, modulo 2^64. */
struct column {
    uint64_t base, step;
    uint64_t mask;   /* 1s, as many as bits */
    uint16_t at;     /* of the first of the bits in a row */
    uint16_t bits;   /* how many they are: 0 to 64 */
    uint16_t offset; /* floats only: in struct trk_sample */
    uint16_t valid;  /* floats only: the TRK_* bit of the rows that have it */
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

struct head {
    uint32_t columns, row_bits;
    uint32_t combined; /* TRK_DIRECTION, TRK_ORIGIN: left out, for trk_combine() makes it */
};

struct block {
    struct head head;
    struct column column[]; /* the rows follow, as words of 64 bits that are filled from the lowest bit on */
};

struct trk_samples {
    struct block **blocks; /* the open one is NULL */
    size_t room;           /* of blocks */
    struct trk_sample *open;
    size_t open_index; /* of the open block; SIZE_MAX: none is */
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

/* Make the combined gaze of a sample that has all but these bits of it. */
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

/* Find how many bits a column's values need in a row, and beyond what. */
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

/* Of the combined gaze, what trk_combine() makes of the eyes in all samples that have it. */
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

/* Find the columns of these samples, and what they need. */
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

/* NULL when memory is short. */
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
