/* The distributions by name. A new one is one file and one line here. */
#include "distribution/distribution.h"

#include <string.h>

static const struct rnd_distribution *const table[] = {
    &rnd_distribution_fv,
    &rnd_distribution_fv_exact,
    &rnd_distribution_vp,
    &rnd_distribution_od,
};

const struct rnd_distribution *rnd_distribution_at(size_t index)
{
    return index < sizeof table / sizeof *table ? table[index] : NULL;
}

const struct rnd_distribution *rnd_distribution_find(const char *name)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(table[i]->name, name) == 0) return table[i];
    return NULL;
}
