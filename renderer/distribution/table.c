/* The distributions, by name and by index. */
#include "distribution/distribution.h"

#include <string.h>

#define ROW(name) &rnd_distribution_##name,
static const struct rnd_distribution *const table[] = {RND_DISTRIBUTIONS(ROW)};

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
