/* Alias tables: draw from any discrete distribution in constant time. */
#ifndef FOVEAD_RENDERER_ALIAS_H
#define FOVEAD_RENDERER_ALIAS_H

#include "math/v3.h"

#include <stdbool.h>
#include <stdint.h>

/* Walker's alias table: draws i with probability weight[i] / sum in constant time. */
struct rnd_alias {
    uint32_t count;
    double sum;
    float *probability; /* of drawing i */
    struct rnd_alias_entry {
        float keep;
        uint32_t other;
    } * entry;
};
/* weights are not negative and not all zero. */
bool rnd_alias_init(struct rnd_alias *alias, const float *weight, uint32_t count);
void rnd_alias_finish(struct rnd_alias *alias);

/* The column for a number in [0,1), and the place within the column, 0 to 1. The number is u, with its bits
 * below 2^-24 in v. */
RND_INLINE uint32_t rnd_alias_place(const struct rnd_alias *alias, float u, float v, float *out_part)
{
    /* 24 bits, which a float has, do not reach every column of a large table. */
    const double place = ((double)u + (double)v * 0x1p-24) * alias->count;
    const uint32_t i = (uint32_t)place, last = alias->count - 1;
    *out_part = (float)(place - i);
    return i < last ? i : last;
}

RND_INLINE uint32_t rnd_alias_draw(const struct rnd_alias *alias, float u, float v)
{
    float part;
    const uint32_t i = rnd_alias_place(alias, u, v, &part);
    return part < alias->entry[i].keep ? i : alias->entry[i].other;
}

#endif
