/* The material at a hit: factors, texture transforms, the second set of texture coordinates, vertex colours
 * and normal maps. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "import/corners.h"
#include "material/point.h"

#include <stdlib.h>

/* A triangle in the plane z = 0 that faces +z. u points to the right and v down, as in a picture on a wall.
 */
static float position[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, uv0[] = {0, 1, 1, 1, 0, 0},
             uv1[] = {0.75f, 0.75f, 0.75f, 0.75f, 0.75f, 0.75f};
static uint32_t triangle[1][3] = {{0, 1, 2}};

static struct rnd_material material;
static struct rnd_texture texture;
static struct rnd_mesh mesh;
static struct rnd_scene scene;

static int setup(void **state)
{
    (void)state;
    material = (struct rnd_material){.kind = RND_RICH,
                                     .base = {{1, 1, 1}},
                                     .metallic = 1,
                                     .roughness = 1,
                                     .ior = 1.5f,
                                     .specular = 1,
                                     .specular_colour = {{1, 1, 1}},
                                     .transmission = 1,
                                     .clearcoat = 1,
                                     .clearcoat_roughness = 1,
                                     .sheen_colour = {{1, 1, 1}},
                                     .sheen_roughness = 1,
                                     .normal_scale = 1,
                                     .clearcoat_normal_scale = 1};
    for (int i = 0; i < RND_MAPS; i++) material.map[i].texture = -1;
    mesh = (struct rnd_mesh){.vertices = 3,
                             .triangles = 1,
                             .position = position,
                             .uv = {uv0, uv1},
                             .index = triangle,
                             .first_light = UINT32_MAX};
    scene = (struct rnd_scene){.mesh_count = 1,
                               .material_count = 1,
                               .texture_count = 1,
                               .mesh = &mesh,
                               .material = &material,
                               .texture = &texture};
    return 0;
}

/* The surface in the middle of the triangle, seen straight on from the front or the back. */
static struct rnd_surface look_by(bool front, const struct rnd_filter *filter)
{
    const struct rnd_point point = {.u = 1 / 3.0f, .v = 1 / 3.0f};
    struct rnd_surface s;
    assert_true(rnd_corners_build(&scene));
    const struct rnd_facing facing =
        rnd_facing_at(&scene, &point, rnd_v3(0, 0, 2), rnd_v3(0, 0, front ? -1.0f : 1.0f));
    rnd_surface_at(&scene, &point, &facing, filter, &s);
    free(scene.corners);
    return s;
}

/* The same with the nearest texel of the finest level. */
static struct rnd_surface look(bool front)
{
    return look_by(front, &(struct rnd_filter){.pick = {0.5f, 0.5f}});
}

/* Use a texture of at most 2 x 2 pixels, as RGBA made from a file with this many channels. */
static void use_texture(int width, int height, int channels, const uint8_t *bytes)
{
    static uint8_t rgba[16];
    for (int i = 0; i < width * height; i++)
        for (int c = 0; c < 4; c++)
            rgba[4 * i + c] = c == 3 && channels < 4 ? 255 : bytes[channels * i + (channels > 1 ? c : 0)];
    texture = (struct rnd_texture){.levels = 1, .level = {{width, height, 0}}, .bytes = rgba};
}

static void every_map_has_its_channel(void **state)
{
    (void)state;
    uint8_t rgba[] = {51, 102, 153, 204}; /* 0.2 0.4 0.6 0.8 */
    use_texture(1, 1, 4, rgba);
    for (int i = 0; i < RND_MAPS; i++)
        if (i != RND_MAP_NORMAL && i != RND_MAP_CLEARCOAT_NORMAL && i != RND_MAP_EMISSION)
            material.map[i].texture = 0;
    const struct rnd_surface s = look(true);
    assert_float_equal(s.base.x, 0.2, 1e-6);
    assert_float_equal(s.base.z, 0.6, 1e-6);
    assert_float_equal(s.alpha, 0.4 * 0.4, 1e-6);
    assert_float_equal(s.metallic, 0.6, 1e-6);
    assert_float_equal(s.layers.transmission, 0.2, 1e-6);
    assert_float_equal(s.layers.specular, 0.8, 1e-6);
    assert_float_equal(s.layers.f0.y, 0.04 * 0.4 * 0.8, 1e-6);
    assert_float_equal(s.layers.coat, 0.2, 1e-6);
    assert_float_equal(s.layers.coat_alpha, 0.4 * 0.4, 1e-6);
    assert_float_equal(s.layers.sheen.y, 0.4, 1e-6);
    assert_float_equal(s.layers.sheen_roughness, 0.8, 1e-6);
    /* no alpha channel: 1 */
    use_texture(1, 1, 3, rgba);
    assert_float_equal(look(true).layers.specular, 1, 1e-6);
    /* vertex colours are stored with 10 bits, and multiply the base */
    float colour[] = {1, 0.5f, 0, 1, 1, 0.5f, 0, 1, 1, 0.5f, 0, 1};
    mesh.colour = colour;
    assert_float_equal(look(true).base.y, 0.2, 5e-4);
    assert_float_equal(look(true).base.z, 0, 1e-6);
}

static void uv_sets_and_transforms(void **state)
{
    (void)state;
    uint8_t grey[] = {0, 51, 102, 204}; /* 2 x 2 texels: 0, 0.2 / 0.4, 0.8 */
    use_texture(2, 2, 1, grey);
    struct rnd_map *map = &material.map[RND_MAP_BASE];
    map->texture = 0;
    map->uv_set = 1; /* all at 0.75, 0.75 */
    assert_float_equal(look(true).base.x, 0.8, 1e-5);
    map->has_transform = true;
    memcpy(map->transform, (float[]){1, 0, -0.5f, 0, 1, 0}, sizeof map->transform);
    assert_float_equal(look(true).base.x, 0.4, 1e-5);
    memcpy(map->transform, (float[]){0, 1, 0, -1, 0, 1}, sizeof map->transform); /* to 0.75, 0.25 */
    assert_float_equal(look(true).base.x, 0.2, 1e-5);
    /* without texture coordinates, all of them count as (0, 0), in both sets */
    mesh.uv[0] = mesh.uv[1] = NULL;
    for (map->uv_set = 0; map->uv_set < 2; map->uv_set++) {
        memcpy(map->transform, (float[]){1, 0, 0.75f, 0, 1, 0.25f}, sizeof map->transform);
        assert_float_equal(look(true).base.x, 0.2, 1e-5);
        memcpy(map->transform, (float[]){1, 0, 0.25f, 0, 1, 0.75f}, sizeof map->transform);
        assert_float_equal(look(true).base.x, 0.4, 1e-5);
    }
}

/* Red leans to the right of the picture, green to its top. From behind the normal is the same, reversed.
 * `scale` makes the lean larger, and a texture that is turned by a quarter turns the lean. */
static void normal_maps(void **state)
{
    (void)state;
    uint8_t red[] = {204, 128, 230}, green[] = {128, 204, 230};
    use_texture(1, 1, 3, red);
    material.map[RND_MAP_NORMAL].texture = 0;
    vec3s n = look(true).shading;
    const float lean = 0.6f / sqrtf(0.36f + 0.8039f * 0.8039f);
    assert_float_equal(n.x, lean, 2e-3);
    assert_float_equal(n.y, 0, 5e-3);
    assert_true(n.z > 0.7f);
    n = look(false).shading;
    assert_float_equal(n.x, -lean, 2e-3);
    assert_true(n.z < -0.7f);
    assert_float_equal(look(true).layers.coat_normal.z, 1, 1e-6);

    use_texture(1, 1, 3, green);
    n = look(true).shading;
    assert_float_equal(n.x, 0, 5e-3);
    assert_float_equal(n.y, lean, 2e-3);
    material.normal_scale = 0.5f;
    assert_float_equal(look(true).shading.y, 0.3f / sqrtf(0.09f + 0.8039f * 0.8039f), 2e-3);
    material.normal_scale = 1;

    /* u' = v, v' = -u: u' grows downwards, so red leans down */
    use_texture(1, 1, 3, red);
    struct rnd_map *map = &material.map[RND_MAP_NORMAL];
    map->has_transform = true;
    memcpy(map->transform, (float[]){0, 1, 0, -1, 0, 0}, sizeof map->transform);
    assert_float_equal(look(true).shading.y, -lean, 2e-3);

    /* A normal that points away is bent towards the viewer. Texture coordinates that do not vary change
     * nothing. */
    uint8_t away[] = {255, 128, 20};
    use_texture(1, 1, 3, away);
    n = look(true).shading;
    assert_true(n.z > 0 && n.z < 0.05f);
    assert_float_equal(glms_vec3_norm(n), 1, 1e-5);
    map->uv_set = 1;
    assert_float_equal(look(true).shading.z, 1, 1e-6);
    map->uv_set = 0;
    map->has_transform = false;
    mesh.uv[0] = uv1;
    assert_float_equal(look(true).shading.z, 1, 1e-6);
}

/* The mean over random numbers is what bilinear interpolation gives. The middle of the triangle, at (1/3,
 * 2/3) of 2 x 2 texels, is 1/6 of a texel to the right of the left ones and 1/6 above the lower ones. */
static void texels_are_picked_by_weight(void **state)
{
    (void)state;
    enum { SIDE = 60 };
    uint8_t grey[] = {0, 51, 102, 204};
    use_texture(2, 2, 1, grey);
    material.map[RND_MAP_BASE].texture = 0;
    double mean = 0.0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const struct rnd_filter filter = {
            .pick = {((float)(i % SIDE) + 0.5f) / SIDE, ((float)(i / SIDE) + 0.5f) / SIDE}};
        mean += look_by(true, &filter).base.x / (SIDE * SIDE);
    }
    const double right = 1.0 / 6.0, down = 5.0 / 6.0;
    assert_float_equal(mean, (1 - down) * right * 0.2 + down * ((1 - right) * 0.4 + right * 0.8), 1e-4);
}

/* A cone as wide as the picture sees the coarsest level, with the first and with the second set of texture
 * coordinates. */
static void levels_by_footprint(void **state)
{
    (void)state;
    /* levels of 4 x 4, 2 x 2 and 1 texels with the values 0, 0.4 and 0.8 */
    static uint8_t rgba[4 * 21];
    for (int i = 0; i < 21; i++) memset(rgba + 4 * i, i < 16 ? 0 : i < 20 ? 102 : 204, 4);
    texture = (struct rnd_texture){
        .levels = 3, .level = {{4, 4, 0}, {2, 2, 16}, {1, 1, 20}}, .bytes = rgba, .log2_size = 2};
    struct rnd_map *map = &material.map[RND_MAP_BASE];
    map->texture = 0;
    static const struct {
        float footprint, value;
    } known[] = {{0, 0}, {0.6f, 0}, {0.8f, 0.4f}, {1.3f, 0.4f}, {1.6f, 0.8f}, {100, 0.8f}};
    float second[] = {0.1f, 1, 1.1f, 1, 0.1f, 0};
    mesh.uv[1] = second;
    for (int set = 0; set < 2; set++)
        for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
            const struct rnd_filter filter = {.footprint = known[k].footprint, .pick = {0.5f, 0.5f}},
                                    finer = {.footprint = 2 * known[k].footprint, .finer = 1};
            map->uv_set = (uint8_t)set;
            assert_float_equal(look_by(true, &filter).base.x, known[k].value, 1e-6);
            assert_float_equal(look_by(true, &finer).base.x, known[k].value, 1e-6);
        }
    mesh.uv[1] = uv1;
    /* The transform halves the texels per metre and turns them: a cone may be twice as wide. */
    map->uv_set = 0;
    map->has_transform = true;
    memcpy(map->transform, (float[]){0, 0.5f, 0, -0.5f, 0, 1}, sizeof map->transform);
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        const struct rnd_filter filter = {.footprint = 2 * known[k].footprint, .pick = {0.5f, 0.5f}};
        assert_float_equal(look_by(true, &filter).base.x, known[k].value, 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(every_map_has_its_channel, setup),
        cmocka_unit_test_setup(uv_sets_and_transforms, setup),
        cmocka_unit_test_setup(normal_maps, setup),
        cmocka_unit_test_setup(texels_are_picked_by_weight, setup),
        cmocka_unit_test_setup(levels_by_footprint, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
