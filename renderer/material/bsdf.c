/* Materials at a hit, by the kind that serves them: Lambert, glTF 2.0 metallic-roughness, all else. */
#include "material/bsdf.h"
#include "material/closure.h"

static struct rnd_mr metal_rough(const struct rnd_surface *s)
{
    const float r = (s->material->ior - 1.0f) / (s->material->ior + 1.0f);
    const float f0 = fminf(r * r, 1.0f) * s->material->specular;
    return rnd_mr(rnd_to_v3(s->base), s->metallic, s->alpha, rnd_v3(f0, f0, f0), s->material->specular);
}

vec3s rnd_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf)
{
    *out_pdf = 0.0f;
    if (surface->material->kind == RND_RICH) {
        struct rnd_closure closure;
        rnd_closure_at(surface, wo, &closure);
        return rnd_closure_evaluate(&closure, wi, out_pdf);
    }
    if (surface->material->kind == RND_DIFFUSE) {
        const float cos_i = glms_vec3_dot(wi, surface->shading);
        if (cos_i <= 0.0f || glms_vec3_dot(wi, surface->geometric) <= 0.0f) return glms_vec3_zero();
        *out_pdf = cos_i / RND_PI;
        return glms_vec3_scale(surface->base, cos_i / RND_PI);
    }
    const struct rnd_mr m = metal_rough(surface);
    const struct rnd_v3_frame frame = rnd_v3_frame(rnd_to_v3(surface->shading));
    struct rnd_v3 f;
    rnd_mr_eval_folded(&m, rnd_v3_to_local(&frame, rnd_to_v3(surface->geometric)),
                       rnd_v3_to_local(&frame, rnd_to_v3(wo)), rnd_v3_to_local(&frame, rnd_to_v3(wi)), &f,
                       out_pdf);
    return rnd_from_v3(f);
}

bool rnd_bsdf_draw(const struct rnd_surface *surface, vec3s wo, const float u[3], struct rnd_bsdf_sample *out)
{
    if (surface->material->kind == RND_RICH) {
        struct rnd_closure closure;
        rnd_closure_at(surface, wo, &closure);
        return rnd_closure_sample(&closure, u, out);
    }
    const struct rnd_v3_frame frame = rnd_v3_frame(rnd_to_v3(surface->shading));
    struct rnd_v3 wi, weight = rnd_to_v3(surface->base);
    if (surface->material->kind == RND_DIFFUSE) {
        wi = rnd_draw_cosine(u[0], u[1]);
        out->pdf = wi.z / RND_PI;
    } else {
        const struct rnd_mr m = metal_rough(surface);
        rnd_mr_draw_folded(&m, rnd_v3_to_local(&frame, rnd_to_v3(surface->geometric)),
                           rnd_v3_to_local(&frame, rnd_to_v3(wo)), rnd_v3(u[0], u[1], u[2]), &wi, &weight,
                           &out->pdf);
    }
    out->wi = rnd_from_v3(rnd_v3_normalize(rnd_v3_to_world(&frame, wi)));
    out->weight = rnd_from_v3(weight);
    out->delta = false;
    return out->pdf > 0.0f && glms_vec3_dot(out->wi, surface->geometric) > 0.0f;
}
