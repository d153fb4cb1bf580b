/* KHR_materials_sheen: fibres that stand up from cloth. The Charlie distribution with its masking. */
#include "material/lobe.h"

/* Roughness below this is taken as this: narrower lobes scatter more light than they get. */
#define LEAST 0.2f

enum { ROUGHNESSES = 12, COSINES = 16 };
/* Albedo of white sheen, by quadrature: rows of roughness even from LEAST to 1, columns of the cosine's
 * square root even from 0 to 1. */
static const float albedo_table[ROUGHNESSES][COSINES] = {
    {1.1826f, 1.1940f, 1.0733f, 0.8821f, 0.6901f, 0.5179f, 0.3721f, 0.2540f, 0.1630f, 0.0967f, 0.0518f,
     0.0242f, 0.0094f, 0.0027f, 0.0004f, 0.0000f},
    {0.9531f, 0.9708f, 0.9025f, 0.7745f, 0.6396f, 0.5131f, 0.4000f, 0.3018f, 0.2189f, 0.1511f, 0.0979f,
     0.0583f, 0.0312f, 0.0140f, 0.0044f, 0.0004f},
    {0.8422f, 0.8630f, 0.8193f, 0.7218f, 0.6155f, 0.5134f, 0.4195f, 0.3349f, 0.2601f, 0.1950f, 0.1397f,
     0.0945f, 0.0595f, 0.0334f, 0.0148f, 0.0032f},
    {0.7911f, 0.8142f, 0.7843f, 0.7030f, 0.6122f, 0.5237f, 0.4410f, 0.3650f, 0.2959f, 0.2335f, 0.1781f,
     0.1300f, 0.0904f, 0.0578f, 0.0315f, 0.0111f},
    {0.7756f, 0.8008f, 0.7792f, 0.7068f, 0.6244f, 0.5433f, 0.4671f, 0.3961f, 0.3305f, 0.2700f, 0.2145f,
     0.1647f, 0.1220f, 0.0851f, 0.0528f, 0.0249f},
    {0.7832f, 0.8105f, 0.7941f, 0.7262f, 0.6478f, 0.5705f, 0.4974f, 0.4291f, 0.3652f, 0.3055f, 0.2498f,
     0.1985f, 0.1537f, 0.1137f, 0.0771f, 0.0435f},
    {0.8061f, 0.8353f, 0.8220f, 0.7556f, 0.6785f, 0.6025f, 0.5306f, 0.4631f, 0.3998f, 0.3400f, 0.2837f,
     0.2310f, 0.1845f, 0.1422f, 0.1026f, 0.0652f},
    {0.8376f, 0.8683f, 0.8565f, 0.7899f, 0.7124f, 0.6361f, 0.5641f, 0.4965f, 0.4328f, 0.3726f, 0.3153f,
     0.2614f, 0.2135f, 0.1696f, 0.1280f, 0.0881f},
    {0.8710f, 0.9028f, 0.8913f, 0.8235f, 0.7448f, 0.6675f, 0.5948f, 0.5266f, 0.4624f, 0.4015f, 0.3434f,
     0.2885f, 0.2396f, 0.1946f, 0.1518f, 0.1106f},
    {0.8985f, 0.9309f, 0.9191f, 0.8501f, 0.7703f, 0.6922f, 0.6190f, 0.5505f, 0.4860f, 0.4247f, 0.3663f,
     0.3110f, 0.2616f, 0.2162f, 0.1730f, 0.1314f},
    {0.9114f, 0.9439f, 0.9320f, 0.8627f, 0.7830f, 0.7053f, 0.6325f, 0.5646f, 0.5008f, 0.4401f, 0.3822f,
     0.3273f, 0.2784f, 0.2334f, 0.1906f, 0.1494f},
    {0.9008f, 0.9329f, 0.9218f, 0.8545f, 0.7770f, 0.7016f, 0.6312f, 0.5655f, 0.5038f, 0.4452f, 0.3891f,
     0.3359f, 0.2886f, 0.2451f, 0.2036f, 0.1638f},
};

static float albedo(float cosine, float roughness)
{
    const float x = sqrtf(fminf(cosine, 1.0f)) * (COSINES - 1),
                y = (fminf(roughness, 1.0f) - LEAST) / (1.0f - LEAST) * (ROUGHNESSES - 1);
    const int c = (int)fminf(x, COSINES - 2), r = (int)fminf(y, ROUGHNESSES - 2);
    const float *low = albedo_table[r], *high = albedo_table[r + 1], fx = x - c, fy = y - r;
    return (1.0f - fy) * ((1.0f - fx) * low[c] + fx * low[c + 1]) +
           fy * ((1.0f - fx) * high[c] + fx * high[c + 1]);
}

/* The fit of Estevez and Kulla 2017 ("Production friendly microfacet sheen BRDF"), eqn 4. */
static float fit(float x, float t)
{
    const float a = 21.5473f + t * (25.3245f - 21.5473f), b = 3.82987f + t * (3.32435f - 3.82987f),
                c = 0.19823f + t * (0.16801f - 0.19823f), d = -1.97760f + t * (-1.27393f + 1.97760f),
                e = -4.32054f + t * (-4.85967f + 4.32054f);
    return a / (1.0f + b * powf(x, c)) + d * x + e;
}

static float lambda(float cosine, float alpha)
{
    const float t = (1.0f - alpha) * (1.0f - alpha);
    if (cosine < 0.5f) return expf(fit(cosine, t));
    return expf(2.0f * fit(0.5f, t) - fit(fmaxf(1.0f - cosine, 0.0f), t));
}

/* BRDF times cosine of white sheen. */
static float lobe(struct rnd_v3 wo, struct rnd_v3 wi, float roughness)
{
    const float alpha = roughness * roughness, o = fmaxf(wo.z, RND_MIN_COSINE);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3_add(wo, wi));
    const float sine = sqrtf(h.x * h.x + h.y * h.y);
    const float d = (2.0f + 1.0f / alpha) * powf(sine, 1.0f / alpha) / (2.0f * RND_PI);
    const float v = 1.0f / (4.0f * o * (1.0f + lambda(o, alpha) + lambda(wi.z, alpha)));
    return d * v / fmaxf(1.0f, albedo(o, roughness));
}

struct sheen {
    float roughness;
};
_Static_assert(sizeof(struct sheen) <= RND_LOBE_BYTES, "a share has room for it");

static bool weigh(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out)
{
    const struct rnd_layers *l = &sight->surface->layers;
    struct sheen *sheen = (void *)out->own;
    const float most = glms_vec3_max(l->sheen);
    if (sight->inside || !(most > 0.0f)) return false;
    sheen->roughness = fmaxf(l->sheen_roughness, LEAST);
    out->strength = left;
    out->taken = out->chance = left * most * fminf(1.0f, albedo(fmaxf(sight->wo.z, 0.0f), sheen->roughness));
    return true;
}

static bool evaluate(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf)
{
    const struct sheen *sheen = (const void *)share->own;
    if (!in->above || in->folded || !(in->local.z > 0.0f)) return false;
    *out_f = rnd_v3_scale(rnd_to_v3(sight->surface->layers.sheen),
                          share->strength * lobe(sight->wo, in->local, sheen->roughness));
    *out_pdf = 0.5f / RND_PI;
    return true;
}

/* Evenly over the hemisphere. */
static bool sample(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out)
{
    (void)share;
    float s, c;
    rnd_turn(u.y, &s, &c);
    const float r = sqrtf(u.x * (2.0f - u.x));
    const struct rnd_v3 wi = {r * c, r * s, 1.0f - u.x};
    out->wi = rnd_unit_to_world(&sight->frame, wi);
    out->above = true;
    out->folds = false;
    return wi.z > 0.0f;
}

const struct rnd_lobe rnd_lobe_sheen = {
    .name = "sheen",
    .source = "Estevez and Kulla 2017, Production friendly microfacet sheen BRDF",
    .weigh = weigh,
    .evaluate = evaluate,
    .sample = sample,
};
