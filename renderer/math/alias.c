/* Walker's alias method, built as Vose 1991 does: draw from any discrete distribution in constant time. */
#include "math/alias.h"
#include "math/large_pages.h"

#include <stdlib.h>

bool rnd_alias_init(struct rnd_alias *alias, const float *weight, uint32_t count)
{
    *alias = (struct rnd_alias){.count = count};
    alias->probability = malloc(count * sizeof *alias->probability);
    alias->entry = malloc(count * sizeof *alias->entry);
    rnd_use_large_pages(alias->entry, count * sizeof *alias->entry);
    double *scaled = malloc(count * sizeof *scaled);
    uint32_t *stack = malloc(count * sizeof *stack); /* small ones from the front, large ones from the back */
    bool ok = alias->probability && alias->entry && scaled && stack;
    if (!ok) goto end;

    for (uint32_t i = 0; i < count; i++) alias->sum += weight[i];
    uint32_t small = 0, large = count;
    for (uint32_t i = 0; i < count; i++) {
        alias->probability[i] = (float)(weight[i] / alias->sum);
        scaled[i] = weight[i] / alias->sum * count;
        alias->entry[i] = (struct rnd_alias_entry){1.0f, i};
        if (scaled[i] < 1.0)
            stack[small++] = i;
        else
            stack[--large] = i;
    }
    while (small > 0 && large < count) {
        const uint32_t s = stack[--small], l = stack[large];
        alias->entry[s] = (struct rnd_alias_entry){(float)scaled[s], l};
        scaled[l] -= 1.0 - scaled[s];
        if (scaled[l] < 1.0) {
            large++;
            stack[small++] = l;
        }
    }
    /* Rounding may leave small entries over, which must not draw an entry without weight. */
    while (small > 0) {
        const uint32_t s = stack[--small];
        if (weight[s] > 0.0f) continue;
        uint32_t any = 0;
        while (!(weight[any] > 0.0f)) any++;
        alias->entry[s] = (struct rnd_alias_entry){0.0f, any};
    }
end:
    free(scaled);
    free(stack);
    if (!ok) rnd_alias_finish(alias);
    return ok;
}

void rnd_alias_finish(struct rnd_alias *alias)
{
    free(alias->probability);
    free(alias->entry);
    *alias = (struct rnd_alias){0};
}
