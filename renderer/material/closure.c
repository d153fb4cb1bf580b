/* Closures: weigh the lobes from the top layer down, add what they scatter, choose one and sample it. */
#include "material/closure.h"

#define ROW(name) &rnd_lobe_##name,
static const struct rnd_lobe *const table[RND_LOBE_COUNT] = {RND_LOBES(ROW)};

void rnd_closure_at(const struct rnd_surface *surface, vec3s wo, struct rnd_closure *out)
{
    out->sight.surface = surface;
    out->sight.towards = rnd_to_v3(wo);
    out->sight.frame = rnd_v3_frame(rnd_to_v3(surface->shading));
    out->sight.wo = rnd_v3_to_local(&out->sight.frame, out->sight.towards);
    out->sight.inside = surface->material->medium && !surface->front;
    out->hidden = surface->between.hidden;
    out->bent = rnd_is_bent(surface, surface->shading);
    out->count = 0;
    if (surface->material->unlit || out->hidden) return;
    float left = 1.0f, sum = 0.0f;
    for (int k = 0; k < RND_LOBE_COUNT; k++) {
        struct rnd_lobe_share *share = &out->share[out->count];
        share->taken = share->chance = 0.0f;
        share->bent = false;
        if (!table[k]->weigh(&out->sight, left, share)) continue;
        out->lobe[out->count++] = table[k];
        out->bent |= share->bent;
        left -= share->taken;
        sum += share->chance;
    }
    const float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    for (int k = 0; k < out->count; k++) out->share[k].chance *= scale;
}

/* Add what the lobes scatter of light from a direction. */
static void add_lobes(const struct rnd_closure *closure, const struct rnd_incoming *in, struct rnd_v3 *sum,
                      float *sum_pdf)
{
    for (int k = 0; k < closure->count; k++) {
        const struct rnd_lobe_share *share = &closure->share[k];
        struct rnd_v3 f;
        float pdf;
        if (!closure->lobe[k]->evaluate(&closure->sight, share, in, &f, &pdf)) continue;
        *sum = rnd_v3_add(*sum, f);
        *sum_pdf += share->chance * pdf;
    }
}

vec3s rnd_closure_evaluate(const struct rnd_closure *closure, vec3s wi, float *out_pdf)
{
    const struct rnd_v3 geometric = rnd_to_v3(closure->sight.surface->geometric);
    struct rnd_incoming in = {.world = rnd_to_v3(wi)};
    struct rnd_v3 sum = {0, 0, 0};
    *out_pdf = 0.0f;
    in.local = rnd_v3_to_local(&closure->sight.frame, in.world);
    in.above = rnd_v3_dot(in.world, geometric) > 0.0f;
    add_lobes(closure, &in, &sum, out_pdf);
    if (closure->bent) {
        in.world = rnd_fold(in.world, geometric);
        in.local = rnd_v3_to_local(&closure->sight.frame, in.world);
        in.folded = true;
        add_lobes(closure, &in, &sum, out_pdf);
    }
    return rnd_from_v3(sum);
}

/* The lobe that a number in [0,1) chooses, and what is left of the number for the lobe's own choices; -1:
 * the surface is black. */
static int choose(const struct rnd_closure *closure, float *number)
{
    int last = -1;
    for (int k = 0; k < closure->count; k++)
        if (closure->share[k].chance > 0.0f) last = k;
    if (last < 0) return -1;
    int k = 0;
    for (; k < last && !(*number < closure->share[k].chance); k++) *number -= closure->share[k].chance;
    *number = fminf(*number / closure->share[k].chance, 0x1.fffffep-1f);
    return k;
}

bool rnd_closure_sample(const struct rnd_closure *closure, const float u[3], struct rnd_scattered *out)
{
    const struct rnd_v3 geometric = rnd_to_v3(closure->sight.surface->geometric);
    struct rnd_lobe_sample sample = {.delta = false};
    if (closure->hidden) {
        const struct rnd_v3 on = rnd_v3_scale(closure->sight.towards, -1.0f);
        *out = (struct rnd_scattered){rnd_from_v3(on), glms_vec3_one(), 1.0f, true};
        return true;
    }
    float number = u[2];
    const int k = choose(closure, &number);
    if (k < 0 ||
        !closure->lobe[k]->sample(&closure->sight, &closure->share[k], rnd_v3(u[0], u[1], number), &sample))
        return false;
    if (sample.above != (rnd_v3_dot(sample.wi, geometric) > 0.0f)) {
        if (!sample.folds) return false;
        sample.wi = rnd_fold(sample.wi, geometric);
    }
    out->wi = rnd_from_v3(sample.wi);
    out->delta = sample.delta;
    if (sample.delta) {
        out->pdf = 1.0f;
        out->weight = rnd_from_v3(sample.weight);
        return true;
    }
    const vec3s f = rnd_closure_evaluate(closure, out->wi, &out->pdf);
    if (!(out->pdf > 0.0f)) return false;
    out->weight = glms_vec3_scale(f, 1.0f / out->pdf);
    return true;
}

vec3s rnd_closure_through(const struct rnd_closure *closure)
{
    struct rnd_v3 sum = {0, 0, 0};
    for (int k = 0; k < closure->count; k++)
        if (closure->lobe[k]->through)
            sum = rnd_v3_add(sum, closure->lobe[k]->through(&closure->sight, &closure->share[k]));
    return rnd_from_v3(sum);
}
