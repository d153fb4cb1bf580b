/* Materials at a hit: Lambert, glTF 2.0 metallic-roughness (GGX over Lambert), smooth dielectric. */
#include "path/shade.h"

#include <string.h>

#define PI ((float)M_PI)

/* Below this GGX's peak outgrows float; a mirror is a lobe of this width. */
#define MIN_ALPHA 1e-3f

static vec3s look(const struct rnd_scene *scene, const struct rnd_map *map, float u, float v)
{
    const struct rnd_texel t = rnd_texture_bilinear(&scene->texture[map->texture], map->wrap, u, v);
    return (vec3s){{t.r, t.g, t.b}};
}

void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_hit *hit, vec3s direction,
                    struct rnd_surface *out)
{
    const struct rnd_mesh *mesh = &scene->mesh[hit->mesh];
    const struct rnd_material *material = &scene->material[mesh->material];
    const uint32_t *index = mesh->index[hit->triangle];
    const float u = hit->u, v = hit->v;

    out->material = material;
    for (int c = 0; c < 3; c++) out->position.raw[c] = rnd_interpolate(mesh->position, 3, c, index, u, v);
    if (hit->instance) out->position = rnd_instance_point(hit->instance, out->position);
    const vec3s outside = glms_vec3_normalize(
        hit->instance ? rnd_instance_normal(hit->instance, hit->normal) : hit->normal);
    out->front = glms_vec3_dot(outside, direction) < 0.0f;
    out->geometric = out->front ? outside : glms_vec3_negate(outside);
    out->shading = out->geometric;
    if (mesh->normal) {
        vec3s n;
        for (int c = 0; c < 3; c++) n.raw[c] = rnd_interpolate(mesh->normal, 3, c, index, u, v);
        if (hit->instance) n = rnd_instance_normal(hit->instance, n);
        n = glms_vec3_normalize(out->front ? n : glms_vec3_negate(n));
        if (glms_vec3_dot(n, direction) < 0.0f && glms_vec3_dot(n, out->geometric) > 0.0f) out->shading = n;
    }
    out->base = material->base;
    out->metallic = material->metallic;
    float roughness = material->roughness;
    if (mesh->uv[0] && (material->map[RND_MAP_BASE].texture >= 0 || material->map[RND_MAP_METAL_ROUGH].texture >= 0)) {
        const float s = rnd_interpolate(mesh->uv[0], 2, 0, index, u, v),
                    t = rnd_interpolate(mesh->uv[0], 2, 1, index, u, v);
        if (material->map[RND_MAP_BASE].texture >= 0)
            out->base =
                glms_vec3_mul(out->base, look(scene, &material->map[RND_MAP_BASE], s, t));
        if (material->map[RND_MAP_METAL_ROUGH].texture >= 0) {
            const vec3s mr = look(scene, &material->map[RND_MAP_METAL_ROUGH], s, t);
            roughness *= mr.y;
            out->metallic *= mr.z;
        }
    }
    out->alpha = fmaxf(roughness * roughness, MIN_ALPHA);
}

/* One float next to another, step representable numbers away. */
static float step_float(float x, int step)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits += x < 0.0f ? -step : step;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

vec3s rnd_leave(const struct rnd_surface *surface, vec3s direction)
{
    const float side = glms_vec3_dot(direction, surface->geometric) >= 0.0f ? 1.0f : -1.0f;
    vec3s out;
    for (int c = 0; c < 3; c++) {
        const float p = surface->position.raw[c], n = side * surface->geometric.raw[c];
        out.raw[c] = fabsf(p) < 1.0f / 32.0f ? p + n / 65536.0f : step_float(p, (int)(256.0f * n));
    }
    return out;
}

/* --- metallic-roughness --- */

static float schlick(float c)
{
    const float m = fmaxf(0.0f, fminf(1.0f, 1.0f - c)), m2 = m * m;
    return m2 * m2 * m;
}

/* Reflectance of the non-metal at normal incidence. */
static float dielectric_f0(const struct rnd_surface *s)
{
    const float r = (s->material->ior - 1.0f) / (s->material->ior + 1.0f);
    return r * r * s->material->specular;
}

static vec3s fresnel(const struct rnd_surface *s, float c)
{
    const float f0 = dielectric_f0(s), f90 = s->material->specular, t = schlick(c);
    const float dielectric = f0 + (f90 - f0) * t;
    const vec3s metal = glms_vec3_adds(glms_vec3_scale(glms_vec3_subs(s->base, 1.0f), 1.0f - t), 1.0f);
    return glms_vec3_lerp((vec3s){{dielectric, dielectric, dielectric}}, metal, s->metallic);
}

/* Share of draws that go to the glossy lobe. */
static float gloss_share(const struct rnd_surface *s, float cos_o)
{
    const vec3s f = fresnel(s, cos_o);
    const float gloss = rnd_luminance(f.raw), matt = rnd_luminance(s->base.raw) * (1.0f - s->metallic);
    if (s->metallic >= 1.0f || matt <= 0.0f) return 1.0f;
    return fmaxf(0.1f, fminf(0.9f, gloss / (gloss + matt)));
}

/* Smith's Lambda for GGX at a cosine. */
static float smith(float c, float alpha)
{
    const float t2 = fmaxf(1.0f - c * c, 0.0f) / (c * c);
    return 0.5f * (sqrtf(1.0f + alpha * alpha * t2) - 1.0f);
}

/* wo, wi in the frame whose z is the normal, both above it. */
static vec3s metal_rough(const struct rnd_surface *s, vec3s wo, vec3s wi, float *out_pdf)
{
    const vec3s h = glms_vec3_normalize(glms_vec3_add(wo, wi));
    const float c = glms_vec3_dot(wo, h), a2 = s->alpha * s->alpha;
    /* h.z^2 (a2 - 1) + 1 without its cancellation where the lobe is narrow */
    const float k = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    const float d = a2 / (PI * k * k);
    const float lo = smith(wo.z, s->alpha), li = smith(wi.z, s->alpha);
    const float share = gloss_share(s, wo.z);
    const float gloss = d / (1.0f + lo + li) / (4.0f * wo.z); /* times cosine */
    *out_pdf = share * d / (1.0f + lo) / (4.0f * wo.z) + (1.0f - share) * wi.z / PI;

    const float f0 = dielectric_f0(s), f = f0 + (s->material->specular - f0) * schlick(c);
    const float matt = (1.0f - s->metallic) * (1.0f - f) * wi.z / PI;
    return glms_vec3_add(glms_vec3_scale(fresnel(s, c), gloss), glms_vec3_scale(s->base, matt));
}

/* A visible normal of GGX (Heitz 2018, "Sampling the GGX distribution of visible normals"). */
static vec3s draw_normal(vec3s wo, float alpha, const float u[2])
{
    const vec3s v = glms_vec3_normalize((vec3s){{alpha * wo.x, alpha * wo.y, wo.z}});
    vec3s t1, t2;
    rnd_frame(v, &t1, &t2);
    const float r = sqrtf(u[0]), phi = 2.0f * PI * u[1];
    /* the frame's own axes, turned so that the disc's second axis points up the normal */
    const float up1 = t1.z, up2 = t2.z, l = sqrtf(up1 * up1 + up2 * up2);
    if (l > 1e-6f) {
        const vec3s b =
            glms_vec3_scale(glms_vec3_add(glms_vec3_scale(t1, up1), glms_vec3_scale(t2, up2)), 1.0f / l);
        t1 = glms_vec3_cross(b, v);
        t2 = b;
    }
    const float p1 = r * cosf(phi), s = 0.5f * (1.0f + v.z);
    const float p2 = (1.0f - s) * sqrtf(fmaxf(1.0f - p1 * p1, 0.0f)) + s * r * sinf(phi);
    vec3s n = glms_vec3_scale(v, sqrtf(fmaxf(1.0f - p1 * p1 - p2 * p2, 0.0f)));
    n = glms_vec3_muladds(t1, p1, n);
    n = glms_vec3_muladds(t2, p2, n);
    return glms_vec3_normalize((vec3s){{alpha * n.x, alpha * n.y, fmaxf(n.z, 1e-6f)}});
}

/* --- smooth dielectric --- */

/* Unpolarised Fresnel reflectance; eta is the index behind over the index in front. *out_cos_t is 0 when all
 * is reflected. */
static float fresnel_dielectric(float cos_i, float eta, float *out_cos_t)
{
    const float sin2 = (1.0f - cos_i * cos_i) / (eta * eta);
    *out_cos_t = 0.0f;
    if (sin2 >= 1.0f) return 1.0f;
    const float cos_t = *out_cos_t = sqrtf(1.0f - sin2);
    const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

static bool draw_dielectric(const struct rnd_surface *s, vec3s wo, float u, struct rnd_bsdf_sample *out)
{
    const float eta = s->front ? s->material->ior : 1.0f / s->material->ior;
    const float cos_o = fminf(glms_vec3_dot(wo, s->shading), 1.0f);
    float cos_t;
    const float reflected = fresnel_dielectric(cos_o, eta, &cos_t);
    out->delta = true;
    out->pdf = 1.0f;
    if (u < reflected) {
        out->wi = glms_vec3_sub(glms_vec3_scale(s->shading, 2.0f * cos_o), wo);
        out->weight = glms_vec3_one();
        return glms_vec3_dot(out->wi, s->geometric) > 0.0f;
    }
    /* Radiance is squeezed by the square of the index (Veach 1997, section 5.2). */
    out->wi =
        glms_vec3_sub(glms_vec3_scale(s->shading, cos_o / eta - cos_t), glms_vec3_scale(wo, 1.0f / eta));
    out->wi = glms_vec3_normalize(out->wi);
    out->weight = glms_vec3_scale(s->base, 1.0f / (eta * eta));
    return glms_vec3_dot(out->wi, s->geometric) < 0.0f;
}

/* --- both --- */

static vec3s to_local(const vec3s axis[3], vec3s w)
{
    return (vec3s){{glms_vec3_dot(w, axis[0]), glms_vec3_dot(w, axis[1]), glms_vec3_dot(w, axis[2])}};
}

static vec3s to_world(const vec3s axis[3], vec3s w)
{
    vec3s out = glms_vec3_scale(axis[0], w.x);
    out = glms_vec3_muladds(axis[1], w.y, out);
    return glms_vec3_muladds(axis[2], w.z, out);
}

vec3s rnd_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf)
{
    const float cos_i = glms_vec3_dot(wi, surface->shading);
    *out_pdf = 0.0f;
    if (cos_i <= 0.0f || glms_vec3_dot(wi, surface->geometric) <= 0.0f) return glms_vec3_zero();
    switch (surface->material->kind) {
    case RND_DIFFUSE:
        *out_pdf = cos_i / PI;
        return glms_vec3_scale(surface->base, cos_i / PI);
    case RND_METAL_ROUGH: {
        vec3s axis[3] = {[2] = surface->shading};
        rnd_frame(axis[2], &axis[0], &axis[1]);
        return metal_rough(surface, to_local(axis, wo), to_local(axis, wi), out_pdf);
    }
    case RND_RICH:
        break;
    }
    return glms_vec3_zero();
}

bool rnd_bsdf_draw(const struct rnd_surface *surface, vec3s wo, const float u[3], struct rnd_bsdf_sample *out)
{
    if (surface->material->kind == RND_RICH) return draw_dielectric(surface, wo, u[2], out);

    vec3s axis[3] = {[2] = surface->shading};
    rnd_frame(axis[2], &axis[0], &axis[1]);
    const vec3s local = to_local(axis, wo);
    vec3s wi;
    if (surface->material->kind == RND_METAL_ROUGH && u[2] < gloss_share(surface, local.z)) {
        const vec3s h = draw_normal(local, surface->alpha, u);
        wi = glms_vec3_sub(glms_vec3_scale(h, 2.0f * glms_vec3_dot(local, h)), local);
    } else { /* cosine by Malley's method */
        const float r = sqrtf(u[0]), phi = 2.0f * PI * u[1];
        wi = (vec3s){{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u[0], 0.0f))}};
    }
    if (wi.z <= 0.0f) return false;
    out->wi = glms_vec3_normalize(to_world(axis, wi));
    out->delta = false;
    const vec3s f = rnd_bsdf(surface, wo, out->wi, &out->pdf);
    if (!(out->pdf > 0.0f)) return false;
    out->weight = glms_vec3_scale(f, 1.0f / out->pdf);
    return true;
}
