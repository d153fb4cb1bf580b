/* Emitters of a group: a table by power, and parts of emitters that are near each other. */
#include "light/emitters.h"

#include <float.h>
#include <stdlib.h>

/* A coordinate from 0 to 1023, as ten bits with two zeros before each. */
static uint32_t spread(float coordinate)
{
    uint32_t bits = (uint32_t)fminf(fmaxf(coordinate, 0.0f), 1023.0f);
    bits = (bits | bits << 16) & 0x030000ffu;
    bits = (bits | bits << 8) & 0x0300f00fu;
    bits = (bits | bits << 4) & 0x030c30c3u;
    return (bits | bits << 2) & 0x09249249u;
}

struct place {
    uint32_t code, emitter;
};

static int by_code(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return x->code != y->code ? (x->code > y->code) - (x->code < y->code)
                              : (x->emitter > y->emitter) - (x->emitter < y->emitter);
}

/* Divide the emitters along a curve on which neighbours are near each other (Morton 1966), into parts that
 * are about equal in number and power. */
static void divide(struct place *place, const vec3s *position, uint32_t count, struct rnd_emitters *emitters)
{
    vec3s low = glms_vec3_fill(INFINITY), high = glms_vec3_fill(-INFINITY);
    for (uint32_t i = 0; i < count; i++) {
        low = glms_vec3_minv(low, position[i]);
        high = glms_vec3_maxv(high, position[i]);
    }
    const float scale = 1023.0f / fmaxf(glms_vec3_max(glms_vec3_sub(high, low)), FLT_MIN);
    for (uint32_t i = 0; i < count; i++) {
        const vec3s p = glms_vec3_scale(glms_vec3_sub(position[i], low), scale);
        place[i] = (struct place){spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2, i};
    }
    qsort(place, count, sizeof *place, by_code);
    double before = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t emitter = place[i].emitter, part = (uint32_t)(before * RND_LIGHT_PARTS);
        emitters->part[emitter] = (uint16_t)(part < RND_LIGHT_PARTS ? part : RND_LIGHT_PARTS - 1);
        before += 0.5 * ((double)emitters->by_power.probability[emitter] + 1.0 / count);
    }
}

bool rnd_emitters_build(struct rnd_emitters *emitters, const vec3s *position, const float *power,
                        uint32_t count)
{
    struct place *place = malloc(count * sizeof *place);
    emitters->part = malloc(count * sizeof *emitters->part);
    const bool ok = place && emitters->part && rnd_alias_init(&emitters->by_power, power, count);
    if (ok) divide(place, position, count, emitters);
    free(place);
    return ok;
}
