/* VP: uniform over the solid angle of the viewport, wherever the eye looks within it.
 *
 * The papers say "uniformly to the area currently viewable". Of the readings of that, solid angle gives the
 * centre of the view the most samples (a flat image plane gives its corners up to 1/cos^3 times more), so it
 * is the strongest opponent for the foveated distribution. Sampling: Urena, Fajardo and King 2013, "An
 * area-preserving parametrization for spherical rectangles".
 */
#include "distribution/distribution.h"
#include "math/sphere.h"

/* A rectangle at distance 1 along -Z, seen from the origin. */
struct viewport {
    float x, y;        /* half extents */
    float b0, b1, k;   /* Urena 2013, section 4 */
    float solid_angle; /* sr */
};

static struct viewport viewport_of(const struct rnd_aim *aim)
{
    const float x = tanf(0.5f * aim->fov[0]), y = tanf(0.5f * aim->fov[1]);
    const vec3s corner[4] = {{{-x, -y, -1}}, {{x, -y, -1}}, {{x, y, -1}}, {{-x, y, -1}}};
    vec3s n[4];
    float g[4];
    for (int i = 0; i < 4; i++) n[i] = glms_vec3_crossn(corner[i], corner[(i + 1) % 4]);
    for (int i = 0; i < 4; i++) g[i] = acosf(-glms_vec3_dot(n[i], n[(i + 1) % 4]));
    const float k = 2.0f * (float)M_PI - g[2] - g[3];
    return (struct viewport){
        .x = x, .y = y, .b0 = n[0].z, .b1 = n[2].z, .k = k, .solid_angle = g[0] + g[1] - k};
}

/* The point of the rectangle for u, v in [0,1), as a unit direction in the view's frame. */
static vec3s viewport_point(const struct viewport *r, float u, float v)
{
    const float au = u * r->solid_angle + r->k;
    const float fu = (cosf(au) * r->b0 - r->b1) / sinf(au);
    const float cu = fmaxf(-1.0f, fminf(1.0f, copysignf(1.0f, fu) / sqrtf(fu * fu + r->b0 * r->b0)));
    const float xu = fmaxf(-r->x, fminf(r->x, cu / sqrtf(fmaxf(1.0f - cu * cu, 1e-12f))));
    const float d = sqrtf(xu * xu + 1.0f);
    const float h = r->y / sqrtf(d * d + r->y * r->y);
    const float hv = (2.0f * v - 1.0f) * h;
    const float yv = hv * d / sqrtf(fmaxf(1.0f - hv * hv, 1e-12f));
    return glms_vec3_normalize((vec3s){{xu, yv, -1.0f}});
}

static versors view_of(const struct rnd_aim *aim)
{
    return (versors){{aim->view[0], aim->view[1], aim->view[2], aim->view[3]}};
}

static void vp_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    const struct viewport r = viewport_of(aim);
    const versors view = view_of(aim);
    for (size_t i = 0; i < count; i++) {
        const vec3s d = glms_quat_rotatev(view, viewport_point(&r, u[2 * i], u[2 * i + 1]));
        glm_vec3_copy((float *)d.raw, out + 3 * i);
    }
}

static float vp_density(const struct rnd_aim *aim, const float direction[3])
{
    const struct viewport r = viewport_of(aim);
    const vec3s d = glms_quat_rotatev(glms_quat_conjugate(view_of(aim)), rnd_vec(direction));
    const bool inside = d.z < 0.0f && fabsf(d.x) <= -d.z * r.x && fabsf(d.y) <= -d.z * r.y;
    return inside ? 1.0f / r.solid_angle : 0.0f;
}

const struct rnd_distribution rnd_distribution_vp = {
    .name = "vp",
    .summary = "uniform over the solid angle of the viewport",
    .source = "Koskela 2018, section 4.1: viewport preview",
    .has_viewport = true,
    .sample = vp_sample,
    .density = vp_density,
};
