/* RND_RICH: clearcoat over sheen over metallic-roughness, part of whose non-metal is glass instead of diffuse.
 *
 * Every layer takes its share of the light, and what is below it gets the rest: 1 - albedo of the layer as
 * seen from wo, which is exact for a world of constant radiance and, as in glTF's own formulas, not
 * reciprocal.
 *
 * - KHR_materials_clearcoat: GGX with Schlick's Fresnel of index 1.5 and a normal of its own.
 * - KHR_materials_sheen: Charlie with the masking of Estevez and Kulla 2017. Roughness below 0.2 is taken as
 *   0.2: narrower lobes give more light back than they get.
 * - KHR_materials_transmission, thin: light that passes keeps to its way, spread as a reflection would be.
 * - KHR_materials_volume: refraction, smooth, or by GGX (Walter et al. 2007), given back what more than one
 *   bounce would bring. It is seen from inside without clearcoat and sheen.
 * - KHR_materials_specular, _ior: reflectance of the non-metal. Glass uses Fresnel's equations, scaled to it.
 * - KHR_materials_unlit: nothing is scattered; the surface's emission is its base colour. */
#include "material/layered.h"

/* --- sheen --- */

enum { SHEEN_ROUGHNESSES = 12, SHEEN_COSINES = 16 };
#define SHEEN_LEAST 0.2f

/* Albedo of white sheen, by quadrature: rows of roughness even from SHEEN_LEAST to 1, columns of the cosine's
 * square root even from 0 to 1. */
static const float sheen_albedo_table[SHEEN_ROUGHNESSES][SHEEN_COSINES] = {
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

static float sheen_albedo(float cosine, float roughness)
{
    const float x = sqrtf(fminf(cosine, 1.0f)) * (SHEEN_COSINES - 1),
                y = (fminf(roughness, 1.0f) - SHEEN_LEAST) / (1.0f - SHEEN_LEAST) * (SHEEN_ROUGHNESSES - 1);
    const int c = (int)fminf(x, SHEEN_COSINES - 2), r = (int)fminf(y, SHEEN_ROUGHNESSES - 2);
    const float *low = sheen_albedo_table[r], *high = sheen_albedo_table[r + 1], fx = x - c, fy = y - r;
    return (1.0f - fy) * ((1.0f - fx) * low[c] + fx * low[c + 1]) +
           fy * ((1.0f - fx) * high[c] + fx * high[c + 1]);
}

/* The fit of Estevez and Kulla 2017 ("Production friendly microfacet sheen BRDF"), eqn 4. */
static float sheen_fit(float x, float t)
{
    const float a = 21.5473f + t * (25.3245f - 21.5473f), b = 3.82987f + t * (3.32435f - 3.82987f),
                c = 0.19823f + t * (0.16801f - 0.19823f), d = -1.97760f + t * (-1.27393f + 1.97760f),
                e = -4.32054f + t * (-4.85967f + 4.32054f);
    return a / (1.0f + b * powf(x, c)) + d * x + e;
}

static float sheen_lambda(float cosine, float alpha)
{
    const float t = (1.0f - alpha) * (1.0f - alpha);
    if (cosine < 0.5f) return expf(sheen_fit(cosine, t));
    return expf(2.0f * sheen_fit(0.5f, t) - sheen_fit(fmaxf(1.0f - cosine, 0.0f), t));
}

/* Times cosine. */
static float sheen_lobe(struct rnd_v3 wo, struct rnd_v3 wi, float roughness)
{
    const float alpha = roughness * roughness, o = fmaxf(wo.z, RND_MIN_COSINE);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3_add(wo, wi));
    const float sine = sqrtf(h.x * h.x + h.y * h.y);
    const float d = (2.0f + 1.0f / alpha) * powf(sine, 1.0f / alpha) / (2.0f * RND_PI);
    const float v = 1.0f / (4.0f * o * (1.0f + sheen_lambda(o, alpha) + sheen_lambda(wi.z, alpha)));
    return d * v / fmaxf(1.0f, sheen_albedo(o, roughness));
}

/* --- what is known once wo is --- */

struct view {
    const struct rnd_surface *s;
    const struct rnd_layers *l;
    struct rnd_v3_frame frame, coat_frame;
    struct rnd_v3 wo, coat_wo;
    struct rnd_mr mr; /* the part that does not transmit */
    float eta;        /* index behind over index in front */
    struct rnd_v3 f0; /* of glass: reflectance ahead */
    bool smooth;      /* glass */
    float pane, rest; /* of the light that does not pass a pane unseen: reflected, and not reflected */
    float sheen_roughness;
    float coat, sheen;                        /* strength of the layers; 0: not there */
    float sheen_share, mr_share, glass_share; /* of the light, that each is given */
    bool bent; /* some of the lobes may be on the wrong side of the triangle: see rnd_fold() */
    float p_coat, p_sheen, p_mr, p_glass; /* chance of each to be drawn */
};

/* What glass reflects and what it lets through, tinted, at a cosine to the facet, and the chance with which
 * reflection is drawn. Fresnel's equations run from f0 to specular as KHR_materials_specular wants. */
struct parting {
    struct rnd_v3 reflected, through;
    float p_reflect, cos_t;
};

static struct parting part(const struct view *v, float cosine)
{
    struct parting out;
    const struct rnd_v3 base = rnd_to_v3(v->s->base);
    if (v->s->pane) {
        const float unseen = glms_vec3_min(v->s->base);
        out.reflected = rnd_v3(v->pane, v->pane, v->pane);
        out.through = rnd_v3_scale(rnd_v3_sub(base, rnd_v3(unseen, unseen, unseen)), v->rest);
    } else {
        const float whole = rnd_fresnel_dielectric(fminf(cosine, 1.0f), v->eta, &out.cos_t);
        if (out.cos_t <= 0.0f) return (struct parting){.reflected = {1, 1, 1}, .p_reflect = 1.0f};
        out.reflected = rnd_v3(rnd_fresnel_scaled(whole, v->eta, v->f0.x, v->l->specular),
                               rnd_fresnel_scaled(whole, v->eta, v->f0.y, v->l->specular),
                               rnd_fresnel_scaled(whole, v->eta, v->f0.z, v->l->specular));
        out.through = rnd_v3_scale(base, 1.0f - rnd_v3_max(out.reflected));
    }
    const float reflect = rnd_v3_sum(out.reflected), pass = rnd_v3_sum(out.through);
    out.p_reflect = reflect + pass > 0.0f ? reflect / (reflect + pass) : 1.0f;
    return out;
}

/* Reflectance ahead of glass whose f0 in air is layers.f0, at the relative index eta. */
static struct rnd_v3 reflectance_ahead(const struct rnd_layers *l, float ior, float eta)
{
    const float air = (ior - 1.0f) / (ior + 1.0f), here = (eta - 1.0f) / (eta + 1.0f), r = here * here;
    if (air * air < 1e-8f) return rnd_v3(l->specular * r, l->specular * r, l->specular * r);
    const float scale = r / (air * air);
    return rnd_v3(fminf(l->f0.x * scale, 1.0f), fminf(l->f0.y * scale, 1.0f), fminf(l->f0.z * scale, 1.0f));
}

static struct view view_of(const struct rnd_surface *s, vec3s wo)
{
    struct view v = {
        .s = s,
        .l = &s->layers,
    };
    const struct rnd_layers *l = v.l;
    const bool inside = s->material->medium && !s->front;
    v.frame = rnd_v3_frame(rnd_to_v3(s->shading));
    v.wo = rnd_v3_to_local(&v.frame, rnd_to_v3(wo));
    if (l->coat > 0.0f) {
        v.coat_frame = rnd_v3_frame(rnd_to_v3(l->coat_normal));
        v.coat_wo = rnd_v3_to_local(&v.coat_frame, rnd_to_v3(wo));
    }
    v.eta = s->material->medium ? s->between.eta : s->material->ior;
    v.f0 = reflectance_ahead(l, s->material->ior, v.eta);
    /* glass of index 1 has no facets that one could see */
    v.smooth = s->alpha <= RND_MIN_ALPHA || (!s->material->thin && fabsf(v.eta - 1.0f) < 1e-3f);
    if (s->pane) {
        float passes;
        const float reflects = rnd_pane_reflects(s->material, glms_vec3_dot(wo, s->geometric), &passes);
        v.pane = passes < 1.0f ? reflects / (1.0f - passes) : 1.0f;
        v.rest = passes < 1.0f ? (1.0f - reflects) / (1.0f - passes) : 0.0f;
    }
    v.sheen_roughness = fmaxf(l->sheen_roughness, SHEEN_LEAST);
    v.bent = glms_vec3_dot(s->shading, s->geometric) < 1.0f - 1e-6f ||
             (l->coat > 0.0f && glms_vec3_dot(l->coat_normal, s->geometric) < 1.0f - 1e-6f);

    float left = 1.0f;
    if (!inside && l->coat > 0.0f && v.coat_wo.z > 0.0f) {
        v.coat = l->coat;
        v.p_coat = v.coat * rnd_reflected(rnd_ggx_albedo(v.coat_wo.z, l->coat_alpha), 0.04f, 1.0f);
        left -= v.p_coat;
    }
    const float sheen = glms_vec3_max(l->sheen);
    if (!inside && sheen > 0.0f) {
        v.sheen = 1.0f;
        v.sheen_share = left;
        v.p_sheen = left * sheen * fminf(1.0f, sheen_albedo(fmaxf(v.wo.z, 0.0f), v.sheen_roughness));
        left -= v.p_sheen;
    }
    const float glass = l->transmission * (1.0f - s->metallic), rest = 1.0f - glass;
    v.glass_share = left * glass;
    v.mr_share = left * rest;
    if (glass > 0.0f) {
        const struct parting p = part(&v, v.wo.z);
        v.p_glass = v.glass_share * (rnd_v3_sum(p.reflected) + rnd_v3_sum(p.through)) / 3.0f;
    }
    if (rest > 0.0f) {
        v.mr = rnd_mr(rnd_to_v3(s->base), s->metallic / rest, s->alpha, rnd_to_v3(l->f0), l->specular);
        v.p_mr = v.mr_share * rnd_mr_view(&v.mr, fmaxf(v.wo.z, RND_MIN_COSINE)).albedo;
    }
    const float sum = v.p_coat + v.p_sheen + v.p_mr + v.p_glass, scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    v.p_coat *= scale, v.p_sheen *= scale, v.p_mr *= scale, v.p_glass *= scale;
    return v;
}

/* --- rough glass --- */

/* A thin sheet: the lobe below is the mirror image of the one above. Both get back what facets hide. */
static struct rnd_v3 thin_glass(const struct view *v, struct rnd_v3 wi, float *out_pdf)
{
    const float alpha = v->s->alpha, o = fmaxf(v->wo.z, RND_MIN_COSINE),
                i = fmaxf(fabsf(wi.z), RND_MIN_COSINE);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3(v->wo.x + wi.x, v->wo.y + wi.y, o + i));
    const float d = rnd_ggx_d(h, alpha), ro = rnd_ggx_reach(o, alpha), ri = rnd_ggx_reach(i, alpha);
    const struct parting p = part(v, rnd_v3_dot(v->wo, h));
    const float gloss = 0.5f * d * i / (i * ro + o * ri) / (1.0f - rnd_ggx_albedo(o, alpha).lost);
    *out_pdf = 0.5f * d / (o + ro) * (wi.z > 0.0f ? p.p_reflect : 1.0f - p.p_reflect);
    return rnd_v3_scale(wi.z > 0.0f ? p.reflected : p.through, gloss);
}

static struct rnd_v3 thick_glass(const struct view *v, struct rnd_v3 wi, float *out_pdf)
{
    const float alpha = v->s->alpha, o = fmaxf(v->wo.z, RND_MIN_COSINE),
                i = fmaxf(fabsf(wi.z), RND_MIN_COSINE);
    const float ro = rnd_ggx_reach(o, alpha), ri = rnd_ggx_reach(i, alpha);
    const bool above = wi.z > 0.0f;
    struct rnd_v3 h = rnd_v3_muladd(wi, above ? 1.0f : v->eta, v->wo);
    *out_pdf = 0.0f;
    if (!(rnd_v3_dot(h, h) > 1e-12f)) return rnd_v3(0, 0, 0); /* index 1: no facet bends light to there */
    h = rnd_v3_scale(rnd_v3_normalize(h), h.z < 0.0f ? -1.0f : 1.0f);
    const float co = rnd_v3_dot(v->wo, h), ci = rnd_v3_dot(wi, h), d = rnd_ggx_d(h, alpha);
    if (co <= 0.0f || (above ? ci <= 0.0f : ci >= 0.0f)) return rnd_v3(0, 0, 0);
    const struct parting p = part(v, co);
    const struct rnd_interface *between = &v->s->between;
    const float more =
        between->glass ? 1.0f / rnd_glass_albedo(between->glass, o, alpha, between->inside) : 1.0f;
    if (above) {
        *out_pdf = p.p_reflect * 0.5f * d / (o + ro);
        return rnd_v3_scale(p.reflected, more * 0.5f * d * i / (i * ro + o * ri));
    }
    /* visible normals: 2 D co / (o + ro); the Jacobian is Walter's eqn 17; masking is separable */
    const float bend = co + v->eta * ci,
                visible = 2.0f * d * co / (o + ro) * -ci / (bend * bend) * v->eta * v->eta;
    *out_pdf = (1.0f - p.p_reflect) * visible;
    return rnd_v3_scale(p.through, more * between->squeeze * visible * 2.0f * i / (i + ri));
}

/* --- all together --- */

static void add(struct rnd_v3 *sum, float *sum_pdf, struct rnd_v3 f, float share, float pdf, float chance)
{
    *sum = rnd_v3_muladd(f, share, *sum);
    *sum_pdf += chance * pdf;
}

/* Add what the lobes have in a direction that is above or below the triangle, or is folded to there; all of
 * them, or the glossy ones alone. */
static void add_lobes(const struct view *v, struct rnd_v3 world, bool above, bool all, struct rnd_v3 *sum,
                      float *sum_pdf)
{
    const struct rnd_v3 wi = rnd_v3_to_local(&v->frame, world);
    struct rnd_v3 f;
    float pdf;
    if (v->coat > 0.0f && above) {
        const struct rnd_v3 c = rnd_v3_to_local(&v->coat_frame, world);
        if (c.z > 0.0f) {
            const float alpha = v->l->coat_alpha, ro = rnd_ggx_reach(v->coat_wo.z, alpha);
            const struct rnd_v3 h = rnd_v3_normalize(rnd_v3_add(v->coat_wo, c));
            const float d = rnd_ggx_d(h, alpha), fresnel = 0.04f + 0.96f * rnd_schlick(rnd_v3_dot(c, h));
            const float gloss =
                0.5f * d * c.z * fresnel / (c.z * ro + v->coat_wo.z * rnd_ggx_reach(c.z, alpha));
            add(sum, sum_pdf, rnd_v3(gloss, gloss, gloss), v->coat, 0.5f * d / (v->coat_wo.z + ro),
                v->p_coat);
        }
    }
    if (above != (wi.z > 0.0f)) return; /* between the two normals */
    if (above && all && v->sheen > 0.0f)
        add(sum, sum_pdf, rnd_to_v3(v->l->sheen), v->sheen_share * sheen_lobe(v->wo, wi, v->sheen_roughness),
            0.5f / RND_PI, v->p_sheen);
    if (above && v->mr_share > 0.0f) {
        if (all) {
            rnd_mr_eval(&v->mr, v->wo, wi, &f, &pdf);
        } else {
            const struct rnd_mr_view mr = rnd_mr_view(&v->mr, fmaxf(v->wo.z, RND_MIN_COSINE));
            rnd_mr_gloss(&v->mr, &mr, v->wo, wi, &f, &pdf);
        }
        add(sum, sum_pdf, f, v->mr_share, pdf, v->p_mr);
    }
    if (v->glass_share > 0.0f && !v->smooth) {
        f = (v->s->material->thin ? thin_glass : thick_glass)(v, wi, &pdf);
        add(sum, sum_pdf, f, v->glass_share, pdf, v->p_glass);
    }
}

static vec3s evaluate(const struct view *v, vec3s world, float *out_pdf)
{
    const struct rnd_v3 wi = rnd_to_v3(world), geometric = rnd_to_v3(v->s->geometric);
    const bool above = rnd_v3_dot(wi, geometric) > 0.0f;
    struct rnd_v3 sum = {0, 0, 0};
    *out_pdf = 0.0f;
    add_lobes(v, wi, above, true, &sum, out_pdf);
    if (v->bent) add_lobes(v, rnd_fold(wi, geometric), above, false, &sum, out_pdf);
    return rnd_from_v3(sum);
}

/* Smooth glass without any other lobe: drawn lights never lie in its single directions. */
static bool is_smooth_glass(const struct rnd_surface *s)
{
    return s->alpha <= RND_MIN_ALPHA && s->layers.transmission == 1.0f && s->metallic == 0.0f &&
           s->layers.coat == 0.0f && glms_vec3_max(s->layers.sheen) == 0.0f;
}

vec3s rnd_rich_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf)
{
    *out_pdf = 0.0f;
    if (surface->material->unlit || surface->between.hidden || is_smooth_glass(surface))
        return glms_vec3_zero();
    const struct view v = view_of(surface, wo);
    return evaluate(&v, wi, out_pdf);
}

vec3s rnd_rich_through(const struct rnd_surface *surface, vec3s wo)
{
    const struct view v = view_of(surface, wo);
    return rnd_from_v3(rnd_v3_scale(part(&v, v.wo.z).through, v.glass_share));
}

/* Where light passes a facet with normal h. */
static struct rnd_v3 pass(const struct view *v, struct rnd_v3 h, float cos_t)
{
    if (v->s->material->thin) {
        const struct rnd_v3 r = rnd_mirror(v->wo, h);
        return rnd_v3(r.x, r.y, -r.z);
    }
    return rnd_v3_muladd(h, rnd_v3_dot(v->wo, h) / v->eta - cos_t, rnd_v3_scale(v->wo, -1.0f / v->eta));
}

/* Light that smooth glass reflects or lets through: u chooses. */
static void draw_smooth_glass(const struct view *v, float u, struct rnd_bsdf_sample *out)
{
    const struct rnd_v3 up = {0, 0, 1};
    const struct parting p = part(v, v->wo.z);
    const bool reflect = u < p.p_reflect;
    const float share = v->glass_share / v->p_glass;
    const float squeeze = v->s->material->medium ? v->s->between.squeeze : 1.0f;
    const struct rnd_v3 wi = reflect ? rnd_mirror(v->wo, up) : pass(v, up, p.cos_t);
    out->delta = true;
    out->pdf = 1.0f;
    out->wi = rnd_from_v3(rnd_v3_normalize(rnd_v3_to_world(&v->frame, wi)));
    out->weight = rnd_from_v3(reflect ? rnd_v3_scale(p.reflected, share / p.p_reflect)
                                      : rnd_v3_scale(p.through, share * squeeze / (1.0f - p.p_reflect)));
    const struct rnd_v3 geometric = rnd_to_v3(v->s->geometric);
    if (reflect != (glms_vec3_dot(out->wi, v->s->geometric) > 0.0f))
        out->wi = rnd_from_v3(rnd_fold(rnd_to_v3(out->wi), geometric));
}

bool rnd_rich_draw(const struct rnd_surface *surface, vec3s wo, const float u[3], struct rnd_bsdf_sample *out)
{
    if (surface->material->unlit) return false;
    if (surface->between.hidden) { /* light goes on as it came */
        *out = (struct rnd_bsdf_sample){glms_vec3_negate(wo), glms_vec3_one(), 1.0f, true};
        return true;
    }
    const struct view v = view_of(surface, wo);
    const struct rnd_v3_frame *frame = &v.frame;
    struct rnd_v3 wi, weight;
    float pdf, rest = u[2];
    bool above = true, glossy = true;
    if (rest < v.p_coat) {
        frame = &v.coat_frame;
        wi = rnd_mirror(v.coat_wo, rnd_draw_ggx_normal(v.coat_wo, v.l->coat_alpha, u[0], u[1]));
    } else if ((rest -= v.p_coat) < v.p_sheen) {
        float s, c;
        rnd_turn(u[1], &s, &c);
        const float r = sqrtf(u[0] * (2.0f - u[0]));
        wi = rnd_v3(r * c, r * s, 1.0f - u[0]);
        glossy = false;
    } else if ((rest -= v.p_sheen) < v.p_mr || v.p_glass <= 0.0f) {
        if (!(v.p_mr > 0.0f)) return false; /* black */
        const float choose = fminf(rest / v.p_mr, 0x1.fffffep-1f);
        rnd_mr_draw(&v.mr, v.wo, rnd_v3(u[0], u[1], choose), &wi, &weight, &pdf);
        glossy = choose < rnd_mr_view(&v.mr, fmaxf(v.wo.z, RND_MIN_COSINE)).share;
    } else {
        const float choose = fminf((rest - v.p_mr) / v.p_glass, 0x1.fffffep-1f);
        if (v.smooth) {
            draw_smooth_glass(&v, choose, out);
            return true;
        }
        const struct rnd_v3 h = rnd_draw_ggx_normal(v.wo, surface->alpha, u[0], u[1]);
        const struct parting p = part(&v, rnd_v3_dot(v.wo, h));
        above = choose < p.p_reflect;
        wi = above ? rnd_mirror(v.wo, h) : pass(&v, h, p.cos_t);
    }
    out->wi = rnd_from_v3(rnd_v3_normalize(rnd_v3_to_world(frame, wi)));
    out->delta = false;
    if (above != (wi.z > 0.0f)) return false; /* into another facet */
    if (above != (glms_vec3_dot(out->wi, surface->geometric) > 0.0f)) {
        if (!glossy) return false;
        out->wi = rnd_from_v3(rnd_fold(rnd_to_v3(out->wi), rnd_to_v3(surface->geometric)));
    }
    const vec3s f = evaluate(&v, out->wi, &out->pdf);
    if (!(out->pdf > 0.0f)) return false;
    out->weight = glms_vec3_scale(f, 1.0f / out->pdf);
    return true;
}
