/* Every lobe of the table keeps to its interface: it scatters no more light than reaches it, samples unit
 * directions on the side that it states, and states the pdf that it samples with. */
#include "renderer_bsdf.h"

#include "material/lobe.h"

#define ROW(name) &rnd_lobe_##name,
static const struct rnd_lobe *const table[] = {RND_LOBES(ROW)};

/* Surfaces that together have all lobes: over thin glass and over a volume, from both sides. */
static const struct case_of_bsdf cases[] = {
    {.name = "over thin glass",
     .kind = RND_RICH,
     .roughness = 0.5f,
     .metallic = 0.3f,
     .specular = 1,
     .transmission = 0.6f,
     .thin = true,
     .coat = 0.7f,
     .coat_roughness = 0.4f,
     .sheen = 0.4f,
     .sheen_roughness = 0.6f},
    {.name = "over a volume",
     .kind = RND_RICH,
     .roughness = 0.5f,
     .specular = 0.8f,
     .transmission = 0.5f,
     .coat = 1,
     .coat_roughness = 0.5f,
     .coat_tilt_deg = 10,
     .sheen = 1,
     .sheen_roughness = 0.3f},
    {.name = "in a volume",
     .kind = RND_RICH,
     .roughness = 0.6f,
     .specular = 1,
     .transmission = 0.5f,
     .coat = 1,
     .back = true},
    {.name = "plain", .kind = RND_RICH, .roughness = 0.4f, .specular = 1},
};
enum { CASES = sizeof cases / sizeof *cases };

static struct rnd_sight sight_of(const struct rnd_surface *s, vec3s wo)
{
    struct rnd_sight sight = {.surface = s,
                              .towards = rnd_to_v3(wo),
                              .frame = rnd_v3_frame(rnd_to_v3(s->shading)),
                              .inside = s->material->medium && !s->front};
    sight.wo = rnd_v3_to_local(&sight.frame, sight.towards);
    return sight;
}

static bool evaluate(const struct rnd_lobe *lobe, const struct rnd_sight *sight,
                     const struct rnd_lobe_share *share, struct rnd_v3 wi, float *out_pdf)
{
    const struct rnd_v3 normal = rnd_to_v3(sight->surface->geometric);
    const struct rnd_incoming in = {
        .world = wi, .local = rnd_v3_to_local(&sight->frame, wi), .above = rnd_v3_dot(wi, normal) > 0.0f};
    struct rnd_v3 f;
    if (!lobe->evaluate(sight, share, &in, &f, out_pdf)) return false;
    assert_true(f.x >= 0.0f && f.y >= 0.0f && f.z >= 0.0f && isfinite(rnd_v3_sum(f)));
    assert_true(*out_pdf >= 0.0f && isfinite(*out_pdf));
    return true;
}

/* Integral of the pdf over all directions, by the midpoint rule. */
static double mass_of(const struct rnd_lobe *lobe, const struct rnd_sight *sight,
                      const struct rnd_lobe_share *share)
{
    enum { UP = 400, AROUND = 200 };
    double sum = 0.0;
    for (int k = 0; k < UP * AROUND; k++) {
        const double theta = (k / AROUND + 0.5) / UP * M_PI,
                     azimuth = (k % AROUND + 0.5) / AROUND * 2.0 * M_PI;
        const vec3s wi = direction(sight->surface, cos(theta), azimuth);
        float pdf;
        if (evaluate(lobe, sight, share, rnd_to_v3(wi), &pdf))
            sum += pdf * sin(theta) * (M_PI / UP) * (2.0 * M_PI / AROUND);
    }
    return sum;
}

static double drawn_of(const struct rnd_lobe *lobe, const struct rnd_sight *sight,
                       const struct rnd_lobe_share *share, uint32_t stream)
{
    enum { DRAWS = 20000 };
    const struct rnd_v3 normal = rnd_to_v3(sight->surface->geometric);
    int drawn = 0;
    for (uint32_t i = 0; i < DRAWS; i++) {
        const struct rnd_v3 u = {stat_uniform(stream, 3 * i), stat_uniform(stream, 3 * i + 1),
                                 stat_uniform(stream, 3 * i + 2)};
        struct rnd_lobe_sample sample = {.delta = false};
        float pdf;
        if (!lobe->sample(sight, share, u, &sample)) continue;
        assert_false(sample.delta);
        assert_float_equal(rnd_v3_dot(sample.wi, sample.wi), 1.0, 1e-5);
        if (sample.above != (rnd_v3_dot(sample.wi, normal) > 0.0f)) continue;
        assert_true(evaluate(lobe, sight, share, sample.wi, &pdf) && pdf > 0.0f);
        drawn++;
    }
    return (double)drawn / DRAWS;
}

static void lobes_keep_to_their_interface(void **state)
{
    (void)state;
    int seen[RND_LOBE_COUNT] = {0};
    for (uint32_t c = 0; c < CASES; c++)
        for (uint32_t k = 0; k < RND_LOBE_COUNT; k++) {
            const struct rnd_lobe *lobe = table[k];
            struct rnd_material material;
            struct rnd_surface s;
            struct rnd_lobe_share share = {.chance = 0.0f};
            make(&cases[c], 0.8f, &material, &s);
            const struct rnd_sight sight = sight_of(&s, direction(&s, 0.6, 0.7));
            if (!lobe->weigh(&sight, 0.75f, &share)) continue;
            seen[k]++;
            assert_true(share.strength > 0.0f && share.taken >= 0.0f && share.taken <= 0.75f);
            assert_true(share.chance > 0.0f && share.chance <= 1.0f);
            const double mass = mass_of(lobe, &sight, &share),
                         drawn = drawn_of(lobe, &sight, &share, RND_LOBE_COUNT * c + k);
            print_message("%-12s %-16s pdf %.4f, sampled %.4f\n", lobe->name, cases[c].name, mass, drawn);
            assert_float_equal(mass, drawn, 0.012);
            if (lobe->through) {
                const struct rnd_v3 through = lobe->through(&sight, &share);
                /* from inside nothing passes: at this angle all is reflected */
                assert_true(sight.inside ? through.x == 0.0f : through.x > 0.0f);
                assert_true(rnd_v3_max(through) < share.strength);
            }
        }
    for (int k = 0; k < RND_LOBE_COUNT; k++) {
        /* metallic-roughness is the only lobe that every surface has */
        assert_true(seen[k] > 0 && (seen[k] == CASES) == (table[k] == &rnd_lobe_metal_rough));
        assert_true(*table[k]->name && *table[k]->source);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lobes_keep_to_their_interface)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
