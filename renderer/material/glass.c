/* Tables of rough glass: means over visible normals, with Fresnel's equations and the masking of thick.c. */
#include "material/glass.h"
#include "material/ggx.h"

#include <stdlib.h>

enum { ROUGHNESSES = 17, COSINES = 33 };

struct rnd_glass {
    float ior;
    float least, range; /* of roughness */
    int rows;           /* roughnesses, closer together where it is low; 1 if there is no range */
    float albedo[2][ROUGHNESSES]
                [COSINES]; /* from without, from inside; cosine's square root even from 0 to 1 */
};

/* Means over count visible normals, whose two numbers are the points of a golden-section lattice. */
static float mean(float cosine, float alpha, float eta, int count)
{
    const float o = fmaxf(cosine, RND_MIN_COSINE), ro = rnd_ggx_reach(o, alpha);
    const struct rnd_v3 wo = {sqrtf(fmaxf(0.0f, 1.0f - o * o)), 0.0f, o};
    double sum = 0.0;
    for (int k = 0; k < count; k++) {
        const double turn = 0.618033988749895 * k;
        const struct rnd_v3 h =
            rnd_draw_ggx_normal(wo, alpha, ((float)k + 0.5f) / (float)count, (float)(turn - floor(turn)));
        const float co = fminf(rnd_v3_dot(wo, h), 1.0f), up = rnd_mirror(wo, h).z;
        float cos_t;
        const float reflected = rnd_fresnel_dielectric(co, eta, &cos_t);
        if (up > 0.0f) sum += reflected * up * (o + ro) / (up * ro + o * rnd_ggx_reach(up, alpha));
        const float down = o / eta - (co / eta - cos_t) * h.z; /* of the refracted way, turned round */
        if (cos_t > 0.0f && down > 0.0f)
            sum += (1.0f - reflected) * 2.0f * down / (down + rnd_ggx_reach(down, alpha));
    }
    return (float)(sum / count);
}

struct rnd_glass *rnd_glass_create(float ior, float least_roughness, float most_roughness)
{
    struct rnd_glass *glass = malloc(sizeof *glass);
    if (!glass) return NULL;
    glass->ior = ior;
    glass->least = least_roughness;
    glass->range = most_roughness - least_roughness;
    glass->rows = glass->range > 0.0f ? ROUGHNESSES : 1;
    for (int inside = 0; inside < 2; inside++)
        for (int r = 0; r < glass->rows; r++)
            for (int c = 0; c < COSINES; c++) {
                const float root = (float)c / (COSINES - 1), part = (float)r / (ROUGHNESSES - 1),
                            roughness = least_roughness + glass->range * part * part;
                glass->albedo[inside][r][c] = mean(root * root, rnd_alpha(roughness),
                                                   inside ? 1.0f / ior : ior, glass->rows == 1 ? 4096 : 1024);
            }
    return glass;
}

bool rnd_glass_is(const struct rnd_glass *glass, float ior, float least_roughness, float most_roughness)
{
    return glass->ior == ior && glass->least == least_roughness &&
           glass->range == most_roughness - least_roughness;
}

float rnd_glass_albedo(const struct rnd_glass *glass, float cosine, float alpha, bool inside)
{
    const float x = sqrtf(fminf(fmaxf(cosine, 0.0f), 1.0f)) * (COSINES - 1);
    const int c = (int)fminf(x, COSINES - 2);
    const float fx = x - (float)c, *low = glass->albedo[inside][0], *high = low;
    float fy = 0.0f;
    if (glass->rows > 1) {
        const float y =
            sqrtf(fminf(fmaxf((sqrtf(alpha) - glass->least) / glass->range, 0.0f), 1.0f)) * (ROUGHNESSES - 1);
        const int r = (int)fminf(y, ROUGHNESSES - 2);
        low = glass->albedo[inside][r];
        high = glass->albedo[inside][r + 1];
        fy = y - (float)r;
    }
    return (1.0f - fy) * ((1.0f - fx) * low[c] + fx * low[c + 1]) +
           fy * ((1.0f - fx) * high[c] + fx * high[c + 1]);
}
