/* The parser of report descriptors: items, the values that they set for later items, and the fields of
 * reports.
 *
 * Numbers in comments are sections of the HID specification 1.11. */
#include "hid_descriptor.h"

#include "error.h"

#include <math.h>
#include <string.h>

enum {
    PAGE = 0x12,
    EYE_TRACKER = 0x01,
    HEAD_TRACKER = 0x02,
    MAX_DEPTH = 32,
    MAX_PUSHED = 16,
    MAX_USAGES = TRK_HID_MAX_DESCRIPTOR / 2, /* every item has at least two bytes */
    CONSTANT = 1,                            /* flags of a main item */
    VARIABLE = 2,
};

/* Ticks must be within these limits to make a clock in nanoseconds. */
static const double finest_s = 1e-9 * (1 - 1e-6), coarsest_s = 1;

/* The dimension of a quantity. */
enum measure { TIME, LENGTH, ANGLE, RATE, NUMBER };

/* X, Y and Z of different things have the same usages: the innermost collection around them tells which thing
 * it is. */
static const struct {
    uint16_t parent, usage; /* parent 0: any */
    uint8_t quantity, measure;
} known[] = {
    {0, 0x20, TRK_HID_TIMESTAMP, TIME},    {0x24, 0x21, TRK_HID_GAZE_X, LENGTH},
    {0x24, 0x22, TRK_HID_GAZE_Y, LENGTH},  {0x25, 0x21, TRK_HID_LEFT_X, LENGTH},
    {0x25, 0x22, TRK_HID_LEFT_Y, LENGTH},  {0x25, 0x23, TRK_HID_LEFT_Z, LENGTH},
    {0x26, 0x21, TRK_HID_RIGHT_X, LENGTH}, {0x26, 0x22, TRK_HID_RIGHT_Y, LENGTH},
    {0x26, 0x23, TRK_HID_RIGHT_Z, LENGTH}, {0x27, 0x21, TRK_HID_HEAD_X, LENGTH},
    {0x27, 0x22, TRK_HID_HEAD_Y, LENGTH},  {0x27, 0x23, TRK_HID_HEAD_Z, LENGTH},
    {0x28, 0x29, TRK_HID_TURN_X, ANGLE},   {0x28, 0x2a, TRK_HID_TURN_Y, ANGLE},
    {0x28, 0x2b, TRK_HID_TURN_Z, ANGLE},   {0, 0x101, TRK_HID_NEAREST, LENGTH},
    {0, 0x103, TRK_HID_FARTHEST, LENGTH},  {0, 0x204, TRK_HID_WIDTH, LENGTH},
    {0, 0x205, TRK_HID_HEIGHT, LENGTH},    {0, 0x300, TRK_HID_FREQUENCY, RATE},
    {0, 0x301, TRK_HID_STATUS, NUMBER},    {0, 0x400, TRK_HID_MODE, NUMBER},
};
enum { KNOWN = sizeof known / sizeof *known };

struct item {
    size_t at; /* of its first byte */
    uint8_t type, tag, size;
    uint32_t data;
};

/* 6.2.2.7. Logical and physical limits are kept as written. Whether a maximum is signed depends on the
 * minimum that is in force when both are used, whichever came first. */
struct globals {
    uint16_t page;
    struct item low, high, physical_low, physical_high;
    int exponent;
    uint32_t unit, size, count;
    uint8_t report;
};

struct usages { /* a range; for a single usage low and high are equal */
    uint32_t low, high;
    bool has_page; /* their upper halves hold the page */
};

struct parser {
    struct trk_hid_layout *out;
    char *out_error;
    struct globals now, pushed[MAX_PUSHED];
    int pushes;
    struct usages usage[MAX_USAGES];
    int usages;
    bool in_delimiter, delimiter_used, has_minimum;
    struct item minimum;
    struct {
        uint16_t page, usage;
    } collection[MAX_DEPTH];
    int depth, tracker_depth; /* tracker_depth: depth of the eye tracker's collection; 0: none is open */
    bool found;
};

static int64_t as_signed(const struct item *item)
{
    switch (item->size) {
    case 1:
        return (int8_t)item->data;
    case 2:
        return (int16_t)item->data;
    default:
        return (int32_t)item->data;
    }
}

/* If the minimum is 0 or more, the maximum is meant as unsigned: many firmwares write 25 FF after 15 00 and
 * mean 255. */
static int64_t as_maximum(const struct item *maximum, int64_t minimum)
{
    return minimum >= 0 ? (int64_t)maximum->data : as_signed(maximum);
}

/* The exponent is four bits as in 6.2.2.7, or a whole signed number, as some firmwares write it. */
static int as_exponent(const struct item *item)
{
    if (item->data <= 15) return item->data < 8 ? (int)item->data : (int)item->data - 16;
    int64_t whole = as_signed(item);
    return whole < -64 || whole > 64 ? 0 : (int)whole;
}

/* --- units --- */

static bool is_power(uint32_t unit, int nibble, uint32_t power)
{
    return (unit & ~UINT32_C(15)) == power << (4 * nibble);
}

/* One unit of the descriptor in m, rad, s or Hz; 0 if it does not measure that. 6.2.2.7: the lowest nibble is
 * the system of units, the second is the power of length or angle, and the fourth that of time. */
static double unit_size(uint32_t unit, enum measure measure)
{
    uint32_t system = unit & 15;
    if (system < 1 || system > 4) return 0;
    switch (measure) {
    case TIME:
        return is_power(unit, 3, 1);
    case RATE:
        return is_power(unit, 3, 15); /* -1 */
    case LENGTH:
        if (!is_power(unit, 1, 1)) return 0;
        return system == 1 ? 0.01 : system == 3 ? 0.0254 : 0;
    case ANGLE:
        if (!is_power(unit, 1, 1)) return 0;
        return system == 2 ? 1 : system == 4 ? M_PI / 180 : 0;
    default:
        return 0;
    }
}

/* Set scale and offset. Returns false if the field's unit does not suit its quantity. */
static bool scale(const struct globals *now, enum measure measure, struct trk_hid_field *field)
{
    double span = (double)field->high - (double)field->low;
    double size = now->unit ? unit_size(now->unit, measure) * pow(10, now->exponent) : 0;
    field->scale = 1;
    if (measure == NUMBER || (measure == RATE && size == 0)) return true;
    if (measure == TIME) {
        field->scale = size != 0 ? size : 1e-6; /* without a unit, all known devices send microseconds */
        return field->scale >= finest_s && field->scale <= coarsest_s;
    }
    if (size == 0) {
        field->is_share = field->quantity == TRK_HID_GAZE_X || field->quantity == TRK_HID_GAZE_Y;
        if (!field->is_share || !field->has_range) return false;
        field->scale = 1 / span;
        field->offset = -(double)field->low / span;
        return true;
    }
    int64_t low = as_signed(&now->physical_low), high = as_maximum(&now->physical_high, low);
    double per_step = 1;
    if (high > low && field->has_range) per_step = ((double)high - (double)low) / span;
    field->scale = size * per_step;
    if (high > low && field->has_range) field->offset = size * ((double)low - (double)field->low * per_step);
    return true;
}

/* --- fields --- */

static const struct trk_hid_field *find(const struct trk_hid_layout *layout, enum trk_hid_type type,
                                        enum trk_hid_quantity quantity, int report)
{
    for (size_t i = 0; i < layout->fields; i++) {
        const struct trk_hid_field *field = &layout->field[i];
        if (field->type == type && field->quantity == quantity && (report < 0 || field->report == report))
            return field;
    }
    return NULL;
}

/* Add the field of one usage of a main item, and of the elements that the usage covers. The elements of a
 * timestamp are one number, for example 8 bytes. */
static void add_field(struct parser *p, enum trk_hid_type type, size_t entry, uint64_t element,
                      uint64_t elements)
{
    struct globals *now = &p->now;
    struct trk_hid_layout *out = p->out;
    int64_t low = as_signed(&now->low), high = as_maximum(&now->high, low);
    bool is_array = known[entry].measure == TIME && elements > 1;
    uint64_t bits = is_array ? elements * now->size : now->size;
    if (bits < 1 || bits > 64 || out->fields == TRK_HID_MAX_FIELDS ||
        find(out, type, known[entry].quantity, now->report))
        return;
    struct trk_hid_field field = {
        .quantity = known[entry].quantity,
        .type = type,
        .report = now->report,
        .bits = (uint8_t)bits,
        .first_bit = (uint16_t)(out->bits[type][now->report] + element * now->size),
        .is_signed = low < 0 && !is_array,
        .has_range = low < high && !is_array,
        .low = low,
        .high = high,
    };
    if (scale(now, known[entry].measure, &field))
        out->field[out->fields++] = field;
    else if (known[entry].measure == ANGLE)
        out->has_unknown_turn = true;
}

/* The usage of the innermost collection that has one; 0 if it is of another page. */
static uint16_t parent_usage(const struct parser *p)
{
    for (int i = p->depth - 1; i >= 0; i--)
        if (p->collection[i].usage) return p->collection[i].page == PAGE ? p->collection[i].usage : 0;
    return 0;
}

/* Find the known usages in the ranges of usages, element by element. The last usage covers all remaining
 * elements (6.2.2.8), which matters only for a timestamp. */
static void add_fields(struct parser *p, enum trk_hid_type type)
{
    uint16_t parent = parent_usage(p);
    uint64_t element = 0;
    for (int i = 0; i < p->usages && element < p->now.count; i++) {
        const struct usages *range = &p->usage[i];
        uint32_t page = range->has_page ? range->low >> 16 : p->now.page;
        uint32_t low = range->low & 0xffff, high = range->high & 0xffff;
        if (high < low) high = low;
        for (size_t k = 0; k < KNOWN && page == PAGE; k++) {
            if (known[k].usage < low || known[k].usage > high) continue;
            if (known[k].parent && known[k].parent != parent) continue;
            uint64_t at = element + (known[k].usage - low);
            bool is_last = i == p->usages - 1 && known[k].usage == high;
            if (at < p->now.count) add_field(p, type, k, at, is_last ? p->now.count - at : 1);
        }
        element += (uint64_t)(high - low) + 1;
    }
}

/* --- items --- */

static bool bad(const struct parser *p, const struct item *item, const char *what)
{
    return trk_fail(p->out_error, "report descriptor, byte %zu: %s", item->at, what);
}

static bool take_report(struct parser *p, const struct item *item, enum trk_hid_type type)
{
    struct globals *now = &p->now;
    uint64_t bits = (uint64_t)now->size * now->count; /* 32-bit factors: no overflow */
    uint16_t *used = &p->out->bits[type][now->report];
    if (bits > (uint64_t)(TRK_HID_MAX_REPORT_BITS - *used))
        return bad(p, item, "a report of more than 4096 bytes");
    /* A constant field with a usage holds live data nevertheless (gaze in the reference descriptor); without
     * a usage it is padding. The values of an array are usages that are on, and not quantities. */
    bool is_array = !(item->data & (VARIABLE | CONSTANT));
    if (p->tracker_depth && !is_array && type != TRK_HID_OUTPUT) add_fields(p, type);
    *used = (uint16_t)(*used + bits);
    return true;
}

static bool open_collection(struct parser *p, const struct item *item)
{
    if (p->depth == MAX_DEPTH) return bad(p, item, "more than 32 collections within one another");
    uint32_t usage = p->usages ? p->usage[0].low : 0;
    bool has_page = p->usages && p->usage[0].has_page;
    p->collection[p->depth].page = has_page ? (uint16_t)(usage >> 16) : p->now.page;
    p->collection[p->depth].usage = (uint16_t)usage;
    if (p->depth == 0 && p->collection[0].page == PAGE &&
        (p->collection[0].usage == EYE_TRACKER || p->collection[0].usage == HEAD_TRACKER)) {
        p->tracker_depth = 1;
        if (p->collection[0].usage == EYE_TRACKER) p->found = true;
    }
    p->depth++;
    return true;
}

static bool close_collection(struct parser *p, const struct item *item)
{
    if (p->depth == 0) return bad(p, item, "the end of a collection that was never begun");
    if (--p->depth == 0) p->tracker_depth = 0;
    return true;
}

static bool take_main(struct parser *p, const struct item *item)
{
    bool ok = true;
    switch (item->tag) {
    case 0x8:
        ok = take_report(p, item, TRK_HID_INPUT);
        break;
    case 0x9:
        ok = take_report(p, item, TRK_HID_OUTPUT);
        break;
    case 0xb:
        ok = take_report(p, item, TRK_HID_FEATURE);
        break;
    case 0xa:
        ok = open_collection(p, item);
        break;
    case 0xc:
        ok = close_collection(p, item);
        break;
    }
    /* Local items hold until the next main item. */
    p->usages = 0;
    p->in_delimiter = p->delimiter_used = p->has_minimum = false;
    return ok;
}

static bool take_global(struct parser *p, const struct item *item)
{
    struct globals *now = &p->now;
    switch (item->tag) {
    case 0x0:
        now->page = (uint16_t)item->data;
        break;
    case 0x1:
        now->low = *item;
        break;
    case 0x2:
        now->high = *item;
        break;
    case 0x3:
        now->physical_low = *item;
        break;
    case 0x4:
        now->physical_high = *item;
        break;
    case 0x5:
        now->exponent = as_exponent(item);
        break;
    case 0x6:
        now->unit = item->data;
        break;
    case 0x7:
        now->size = item->data;
        break;
    case 0x8:
        if (item->data < 1 || item->data > 255) return bad(p, item, "a report id that is not 1 to 255");
        now->report = (uint8_t)item->data;
        p->out->numbered = true;
        break;
    case 0x9:
        now->count = item->data;
        break;
    case 0xa:
        if (p->pushes == MAX_PUSHED) return bad(p, item, "more than 16 pushes");
        p->pushed[p->pushes++] = *now;
        break;
    case 0xb:
        if (p->pushes == 0) return bad(p, item, "a pop without a push");
        *now = p->pushed[--p->pushes];
        break;
    }
    return true;
}

static void add_usages(struct parser *p, uint32_t low, uint32_t high, bool has_page)
{
    /* Delimiters enclose alternative usages, and the first one is preferred (6.2.2.8). */
    if (p->in_delimiter && p->delimiter_used) return;
    p->delimiter_used = p->in_delimiter;
    if (p->usages < MAX_USAGES) p->usage[p->usages++] = (struct usages){low, high, has_page};
}

static void take_local(struct parser *p, const struct item *item)
{
    switch (item->tag) {
    case 0x0:
        add_usages(p, item->data, item->data, item->size == 4);
        break;
    case 0x1:
        p->minimum = *item;
        p->has_minimum = true;
        break;
    case 0x2:
        if (!p->has_minimum) break;
        add_usages(p, p->minimum.data, item->data, p->minimum.size == 4);
        p->has_minimum = false;
        break;
    case 0xa:
        p->in_delimiter = item->data & 1;
        p->delimiter_used = false;
        break;
    }
}

/* Take the next item. Returns false at the end, and with a line in out_error if the item is cut off. */
static bool next_item(struct parser *p, const uint8_t *bytes, size_t size, size_t *at, struct item *out_item)
{
    if (*at == size) return false;
    uint8_t prefix = bytes[*at];
    *out_item = (struct item){
        .at = *at, .type = prefix >> 2 & 3, .tag = prefix >> 4, .size = (prefix & 3) == 3 ? 4 : prefix & 3};
    size_t left = size - *at - 1, length = out_item->size;
    bool is_long = prefix == 0xfe; /* 6.2.2.3, a long item, which has no defined use: length, tag, data */
    if (is_long) length = left >= 1 ? 2 + (size_t)bytes[*at + 1] : 2;
    if (length > left) return bad(p, out_item, "an item that is cut short");
    for (size_t i = 0; !is_long && i < length; i++) out_item->data |= (uint32_t)bytes[*at + 1 + i] << (8 * i);
    *at += 1 + length;
    return true;
}

bool trk_hid_parse(const uint8_t *bytes, size_t size, struct trk_hid_layout *out_layout,
                   char out_error[TRK_ERROR_SIZE])
{
    struct parser p = {.out = out_layout, .out_error = out_error};
    struct item item;
    size_t at = 0;
    memset(out_layout, 0, sizeof *out_layout);
    out_error[0] = '\0';
    if (size > TRK_HID_MAX_DESCRIPTOR)
        return trk_fail(out_error, "report descriptor of %zu bytes, expected up to %d", size,
                        TRK_HID_MAX_DESCRIPTOR);
    while (next_item(&p, bytes, size, &at, &item)) {
        if (item.type == 0 && !take_main(&p, &item)) return false;
        if (item.type == 1 && !take_global(&p, &item)) return false;
        if (item.type == 2) take_local(&p, &item);
    }
    if (out_error[0]) return false;
    item.at = size;
    if (p.depth) return bad(&p, &item, "the end within a collection");
    if (!p.found) return trk_fail(out_error, "report descriptor: no eye tracker (usage page 0x12, usage 1)");
    if (!trk_hid_find(out_layout, TRK_HID_INPUT, TRK_HID_GAZE_X) ||
        !trk_hid_find(out_layout, TRK_HID_INPUT, TRK_HID_GAZE_Y))
        return trk_fail(out_error, "report descriptor: the eye tracker reports no gaze point X and Y");
    return true;
}

const struct trk_hid_field *trk_hid_find(const struct trk_hid_layout *layout, enum trk_hid_type type,
                                         enum trk_hid_quantity quantity)
{
    return find(layout, type, quantity, -1);
}

unsigned trk_hid_clock_bits(const struct trk_hid_field *timestamp)
{
    if (timestamp->has_range && timestamp->low == 0)
        for (unsigned bits = 8; bits < timestamp->bits; bits++)
            if (timestamp->high == (INT64_C(1) << bits) - 1) return bits;
    return timestamp->bits;
}
