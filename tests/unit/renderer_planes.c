/* The film's planes: albedo, normals, positions, coverage and instances, in rooms where they are known. */
#include "renderer_parts.h"
#include "renderer_room.h"

#include "render.h"

/* --- a reconstruction that shows a plane --- */

enum { ALL = (1u << RND_PLANES) - 1, MARGIN = 5 };

static enum rnd_plane_id looked_at; /* the plane that is shown; a plane of one channel is followed by zeros */

static int channels_of(enum rnd_plane_id plane)
{
    return plane == RND_PLANE_COVERAGE || plane == RND_PLANE_INSTANCE ? 1 : 3;
}

static bool run_plane(void *memory, const struct rnd_window *window, float *out_rgb)
{
    (void)memory;
    memset(out_rgb, 0, RND_TILE * RND_TILE * 3 * sizeof *out_rgb);
    for (int i = 0; i < RND_TILE * RND_TILE; i++) {
        const float *from = rnd_window_plane(window, looked_at, i);
        memcpy(&out_rgb[3 * i], from, (size_t)channels_of(looked_at) * sizeof *from);
    }
    return true;
}

static const struct rnd_reconstruction shows_planes = {.name = "planes", .planes = ALL, .run = run_plane};

static struct rnd_render *make_with(const struct rnd_scene *scene, const struct rnd_reconstruction *row,
                                    int width, const char *distribution, int threads)
{
    const struct rnd_render_options options = {.width = width,
                                               .height = width / 2,
                                               .threads = threads,
                                               .seed = 42,
                                               .distribution = rnd_distribution_find(distribution),
                                               .reconstruction = row};
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    return render;
}

/* The planes of a film, or of one of its levels, each as a picture. */
struct seen {
    int width, height;
    float plane[RND_PLANES][3 * PIXELS];
};

static void look_at_planes(struct rnd_render *render, int level, struct seen *out)
{
    float rgb[RND_TILE * RND_TILE * 3];
    out->width = render->film.width >> level;
    out->height = render->film.height >> level;
    assert_true(out->width * out->height <= PIXELS);
    for (int p = 0; p < RND_PLANES; p++)
        for (int top = 0; top < out->height; top += RND_TILE)
            for (int left = 0; left < out->width; left += RND_TILE) {
                looked_at = (enum rnd_plane_id)p;
                assert_true(rnd_render_read(render, level, left / RND_TILE, top / RND_TILE, rgb, NULL));
                for (int y = 0; y < RND_TILE; y++)
                    memcpy(&out->plane[p][3 * ((top + y) * out->width + left)], &rgb[3 * RND_TILE * y],
                           3 * RND_TILE * sizeof *rgb);
            }
}

/* Is the unit direction d within pixel i? The tolerance is a little more than rounding. */
static bool is_in_pixel(const struct seen *seen, int i, const double d[3])
{
    const double u = (0.5 + atan2(d[0], -d[2]) / (2 * M_PI)) * seen->width - i % seen->width,
                 v = (0.5 - asin(d[1]) / M_PI) * seen->height - i / seen->width;
    return u > -1e-3 && u < 1.001 && v > -1e-3 && v < 1.001;
}

static void uniform(struct rnd_render *render, int per_pixel)
{
    const struct rnd_aim aim = files_aim(0, 0, -1);
    struct rnd_batch batch;
    for (int i = 0; i < per_pixel; i++)
        rnd_render_batch(render, &aim, 1, (uint32_t)(render->film.width * render->film.height), &batch);
}

/* --- a box without a lid, seen from its middle --- */

enum { W = 256 };
static const double half_box[3] = {2, 1.5, 2.5}, camera[3] = {0.3, -0.2, 0.4};

static const char *open_box(void)
{
    char text[2000] = "mtllib open.mtl\n";
    size_t n = strlen(text);
    files_text("open.mtl", "newmtl left\nKd 0.5 0.1 0.1\nnewmtl right\nKd 0.1 0.5 0.1\nnewmtl floor\n"
                           "Kd 0.7 0.7 0.2\nnewmtl front\nKd 0.2 0.2 0.8\nnewmtl back\nKd 0.3 0.6 0.9\n");
    for (int i = 0; i < 8; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "v %g %g %g\n", (i & 1 ? 1 : -1) * half_box[0],
                              (i & 2 ? 1 : -1) * half_box[1], (i & 4 ? 1 : -1) * half_box[2]);
    snprintf(text + n, sizeof text - n,
             "usemtl left\nf 1 3 7 5\nusemtl right\nf 2 6 8 4\nusemtl floor\nf 1 5 6 2\nusemtl front\n"
             "f 1 2 4 3\nusemtl back\nf 5 7 8 6\n");
    return files_text("open.obj", text);
}

/* Which wall is seen in a direction: returns the axis that the wall is perpendicular to, and its side. Axis 1
 * with side 1 is the sky. */
static int wall_at(const double d[3], int *out_side)
{
    double nearest = INFINITY;
    int axis = 0;
    for (int k = 0; k < 3; k++) {
        const double t = d[k] == 0 ? INFINITY : (copysign(half_box[k], d[k]) - camera[k]) / d[k];
        if (t < nearest) nearest = t, axis = k;
    }
    *out_side = d[axis] > 0 ? 1 : -1;
    return axis;
}

/* The wall that all of pixel i shows; -1 if the pixel shows several. */
static int wall_of(const struct seen *seen, int i, int *out_side)
{
    int wall = -1;
    for (int k = 0; k < 25; k++) {
        float d[3];
        int side = 0;
        rnd_direction((float)(((i % seen->width + k % 5 / 4.0) / seen->width - 0.5) * 2 * M_PI),
                      (float)((0.5 - (i / seen->width + k / 5 / 4.0) / seen->height) * M_PI), d);
        const int axis = wall_at((const double[]){(double)d[0], (double)d[1], (double)d[2]}, &side);
        if (k > 0 && (axis != wall || side != *out_side)) return -1;
        wall = axis;
        *out_side = side;
    }
    return wall;
}

static void walls(void **state)
{
    (void)state;
    static const double colours[3][2][3] = {
        {{0.5, 0.1, 0.1}, {0.1, 0.5, 0.1}}, {{0.7, 0.7, 0.2}, {0}}, {{0.2, 0.2, 0.8}, {0.3, 0.6, 0.9}}};
    static struct seen seen;
    int counts[2] = {0}, mixed = 0, instances[3][2] = {{0}};
    struct rnd_scene *scene = files_load(open_box(), files_env("white.exr", 1), NULL,
                                         (float[]){(float)camera[0], (float)camera[1], (float)camera[2]});
    const double *origin = scene->origin;
    struct rnd_render *render = make_with(scene, &shows_planes, W, "od", 2);
    uniform(render, 12);
    look_at_planes(render, 0, &seen);
    for (int i = 0; i < seen.width * seen.height; i++) {
        int side = 0;
        const int axis = wall_of(&seen, i, &side), s = side > 0;
        const float *albedo = &seen.plane[RND_PLANE_ALBEDO][3 * i],
                    *normal = &seen.plane[RND_PLANE_NORMAL][3 * i],
                    *position = &seen.plane[RND_PLANE_POSITION][3 * i],
                    coverage = seen.plane[RND_PLANE_COVERAGE][3 * i],
                    instance = seen.plane[RND_PLANE_INSTANCE][3 * i];
        if (axis == 1 && side == 1) { /* the sky */
            for (int c = 0; c < 3; c++) assert_true(albedo[c] == 0 && normal[c] == 0 && position[c] == 0);
            assert_true(coverage == 0 && instance == 0);
            counts[0]++;
        }
        if (axis < 0 && coverage > 0 && coverage < 1) mixed++; /* wall and sky: the mean over all paths */
        if (axis < 0 || (axis == 1 && side == 1)) continue;
        double d[3], length = 0;
        for (int c = 0; c < 3; c++) {
            assert_float_equal(albedo[c], colours[axis][s][c], 1e-3);
            assert_float_equal(normal[c], c == axis ? -side : 0, 1e-4);
            d[c] = (double)position[c] + origin[c] - camera[c];
            length += d[c] * d[c];
        }
        assert_float_equal(position[axis] + origin[axis], side * half_box[axis], 1e-5);
        for (int c = 0; c < 3; c++) d[c] /= sqrt(length);
        if (i / W > 2 && i / W < W / 2 - 3 && !is_in_pixel(&seen, i, d))
            fail_msg("pixel %d: its position", i);
        assert_true(coverage == 1 && instance >= 1);
        if (instances[axis][s] == 0) instances[axis][s] = (int)instance;
        assert_int_equal(instance, instances[axis][s]);
        counts[1]++;
    }
    print_message("pixels of sky %d, of one wall %d, of sky and wall %d\n", counts[0], counts[1], mixed);
    assert_true(counts[0] > 3000 && counts[1] > 20000 && mixed > 100);
    for (int a = 0; a < 5; a++) /* each wall is a mesh of its own */
        for (int b = a + 1; b < 6; b++)
            if (a != 3 && b != 3) assert_int_not_equal(instances[a / 2][a % 2], instances[b / 2][b % 2]);
    rnd_render_destroy(render);
    rnd_scene_destroy(scene);
}

/* --- a square under the camera: kinds of material, textures, vertex colours, normal maps, instances --- */

enum { MANY = 1200 }; /* the mesh repeats the square, so that its instances share it */

/* normal: of the square's vertices. */
static const char *square(const char *nodes, const char *material, const double normal[3])
{
    static float normals[12];
    /* red grows along x, green along z, and blue falls along x */
    static const float colours[12] = {0, 0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 0};
    static uint16_t many[6 * MANY];
    for (int i = 0; i < 6 * MANY; i++) many[i] = files_two[i % 6];
    for (int i = 0; i < 12; i++) normals[i] = (float)normal[i % 3];
    const struct files_part parts[] = {
        {files_corners, sizeof files_corners, "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""},
        {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},
        {many, sizeof many, "\"componentType\":5123,\"count\":7200,\"type\":\"SCALAR\""},
        {normals, sizeof normals, "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""},
        {colours, sizeof colours, "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""}};
    return files_parts(
        "square.gltf",
        "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"NORMAL\":3,\"COLOR_0\":4},"
        "\"indices\":2,\"material\":0}",
        nodes, material,
        ",\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":1}],\"samplers\":[{\"magFilter\":"
        "9728,\"minFilter\":9728}],\"images\":[{\"uri\":\"halves.exr\"},{\"uri\":\"lean.exr\"}]",
        parts, 5);
}

/* Is this place far enough from the edges, and from the middle, where the texture changes? */
static bool is_inside(const double local[3])
{
    return fabs(local[0]) < 0.95 && fabs(local[2]) < 0.95 && fabs(local[0]) > 0.05;
}

/* Check all pixels that show the square, which is scaled, turned and moved. own_normal is in the square's own
 * coordinates. Returns how many pixels there were. */
static int check_square(const struct seen *seen, const double *origin, const double turn[3][3],
                        const double scale[3], const double move[3], const double own_normal[3], int instance)
{
    static const double half[2][3] = {{0.8, 0.4, 0.2}, {0.1, 0.6, 1.0}};
    int count = 0;
    for (int i = 0; i < seen->width * seen->height; i++) {
        double p[3], local[3], normal[3] = {0}, length = 0, seen_from = 0;
        float d[3];
        if (seen->plane[RND_PLANE_COVERAGE][3 * i] != 1) continue;
        if (instance && seen->plane[RND_PLANE_INSTANCE][3 * i] != (float)instance) continue;
        for (int c = 0; c < 3; c++)
            p[c] = (double)seen->plane[RND_PLANE_POSITION][3 * i + c] + origin[c] - move[c];
        for (int c = 0; c < 3; c++) {
            local[c] = (turn[0][c] * p[0] + turn[1][c] * p[1] + turn[2][c] * p[2]) / scale[c];
            for (int k = 0; k < 3; k++) normal[k] += turn[k][c] * own_normal[c];
        }
        if (fabs(local[1]) > 1e-4 || !is_inside(local)) continue;
        const double own[3] = {(local[0] + 1) / 2, (local[2] + 1) / 2, (1 - local[0]) / 2};
        rnd_direction((float)(((i % seen->width + 0.5) / seen->width - 0.5) * 2 * M_PI),
                      (float)((0.5 - (i / seen->width + 0.5) / seen->height) * M_PI), d);
        for (int c = 0; c < 3; c++) length += normal[c] * normal[c], seen_from -= normal[c] * (double)d[c];
        if (seen_from < 0.1 * sqrt(length)) continue; /* at flat angles normals are bent towards the viewer */
        for (int c = 0; c < 3; c++) {
            assert_float_equal(seen->plane[RND_PLANE_ALBEDO][3 * i + c], own[c] * half[local[0] > 0][c],
                               2e-3);
            assert_float_equal(seen->plane[RND_PLANE_NORMAL][3 * i + c], normal[c] / sqrt(length), 2e-3);
        }
        count++;
    }
    return count;
}

static void materials(void **state)
{
    (void)state;
    static const char *const kinds[] = {
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}},\"extensions\":"
        "{\"KHR_materials_specular\":{\"specularFactor\":0}}}",
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0.5,\"baseColorTexture\":{\"index\":0}}}",
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0.5,\"baseColorTexture\":{\"index\":0}},"
        "\"normalTexture\":{\"index\":1}}",
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},\"normalTexture\":{\"index\":1},"
        "\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}}}"};
    static const enum rnd_material_kind kind[] = {RND_DIFFUSE, RND_METAL_ROUGH, RND_METAL_ROUGH, RND_RICH};
    static const double up[3] = {0, 1, 0}, oblique[3] = {0.6, 0.8, 0},
                        mapped[3] = {0, 0.8660254, -0.5}; /* the top of the picture is towards -z */
    static const double turn[2][3][3] = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                         {{0.8, -0.6, 0}, {0.6, 0.8, 0}, {0, 0, 1}}};
    static const double scale[2][3] = {{1, 1, 1}, {2, 0.5, 1}}, move[2][3] = {{0, 0, 0}, {0, 0, -3}};
    static struct seen seen;
    const float halves[6] = {0.8f, 0.4f, 0.2f, 0.1f, 0.6f, 1.0f}, lean[3] = {0.5f, 0.75f, 0.9330127f};
    char error[RND_ERROR_SIZE];
    assert_true(files_image(files_path("halves.exr"), 2, 1, halves, false, error));
    assert_true(files_image(files_path("lean.exr"), 1, 1, lean, false, error));
    for (int shared = 0; shared < 2; shared++)
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            const char *nodes = shared ? "{\"children\":[1,2]},{\"mesh\":0},{\"mesh\":0,\"scale\":[2,0.5,1],"
                                         "\"translation\":[0,0,-3],\"rotation\":[0,0,0.31622777,0.9486833]}"
                                       : "{\"mesh\":0}";
            struct rnd_scene *scene =
                files_load(square(nodes, kinds[k], k < 2 ? oblique : up), files_env("white.exr", 1), NULL,
                           (float[]){0.1f, 1.5f, -0.8f});
            assert_int_equal(scene->material[0].kind, kind[k]);
            assert_int_equal(scene->instance_count, shared ? 2 : 0);
            struct rnd_render *render = make_with(scene, &shows_planes, 512, "od", 2);
            uniform(render, 3);
            look_at_planes(render, 0, &seen);
            for (int s = 0; s <= shared; s++) {
                /* Where lengths grow, normals shrink. A map bends the normal along the surface as it is in
                 * the world. */
                const double stretched[3] = {oblique[0] / scale[s][0], oblique[1] / scale[s][1], 0};
                const int count = check_square(&seen, scene->origin, turn[s], scale[s], move[s],
                                               k < 2 ? stretched : mapped, shared ? 2 + s : 0);
                print_message("material %zu, %s %d: %d pixels\n", k, shared ? "instance" : "mesh", s, count);
                assert_true(count > 900);
            }
            rnd_render_destroy(render);
            rnd_scene_destroy(scene);
        }
}

/* --- threads and planes do not change the film --- */

static void threads(void **state)
{
    (void)state;
    static struct film film[3];
    static struct seen seen[2];
    for (int i = 0; i < 3; i++) {
        struct rnd_render *render =
            make_with(room, i < 2 ? &shows_planes : NULL, WIDTH, "fv", i == 1 ? 3 : 1);
        look_around(render, 8, 6000 + 77);
        rnd_render_resolve(render, film[i].rgb, film[i].samples, film[i].error);
        if (i < 2) look_at_planes(render, 0, &seen[i]);
        if (i == 0) { /* started anew, the planes are the same */
            rnd_render_restart(render, room, (const double[]){1, 0, 1});
            look_around(render, 5, 3000);
            rnd_render_restart(render, room, rnd_scene_info(room)->camera);
            look_around(render, 8, 6000 + 77);
            look_at_planes(render, 0, &seen[1]);
            assert_memory_equal(&seen[0], &seen[1], sizeof seen[0]);
        }
        rnd_render_destroy(render);
    }
    assert_memory_equal(&seen[0], &seen[1], sizeof seen[0]);
    assert_memory_equal(&film[0], &film[1], sizeof film[0]);
    assert_memory_equal(&film[0], &film[2], sizeof film[0]); /* the radiance without planes is the same */
}

/* --- levels --- */

/* Check that a pixel of a level is the mean of the pixels below it that have paths. */
static void check_level(struct rnd_render *render, int level, const struct film *film)
{
    static struct seen fine, coarse;
    const int span = 1 << level;
    int filled = 0, partial = 0;
    look_at_planes(render, 0, &fine);
    look_at_planes(render, level, &coarse);
    for (int i = 0; i < coarse.width * coarse.height; i++) {
        double mean[RND_PLANES][3] = {{0}}, parts = 0;
        bool has_instance = false;
        for (int k = 0; k < span * span; k++) {
            const int at =
                (i / coarse.width * span + k / span) * fine.width + i % coarse.width * span + k % span;
            if (film->samples[at] == 0) continue;
            parts++;
            for (int p = 0; p < RND_PLANES; p++)
                for (int c = 0; c < 3; c++) mean[p][c] += (double)fine.plane[p][3 * at + c];
            has_instance |= fine.plane[RND_PLANE_INSTANCE][3 * at] == coarse.plane[RND_PLANE_INSTANCE][3 * i];
        }
        filled += parts > 0;
        partial += parts > 0 && parts < span * span;
        for (int p = 0; p < RND_PLANES; p++)
            for (int c = 0; c < 3 && p != RND_PLANE_INSTANCE; c++)
                assert_float_equal(coarse.plane[p][3 * i + c], parts > 0 ? mean[p][c] / parts : 0, 1e-5);
        assert_true(parts > 0 ? has_instance : coarse.plane[RND_PLANE_INSTANCE][3 * i] == 0);
    }
    print_message("level %d: %d pixels, of which %d have parts without a path\n", level, filled, partial);
    assert_true(filled > 0 && partial > 0);
}

/* A film of 512 x 256 pixels has three levels, made from pixels. A wider one also has levels made from
 * blocks. */
static void levels(void **state)
{
    (void)state;
    static struct film film;
    struct rnd_render *render = make_with(room, &shows_planes, WIDTH, "fv", 2);
    for (int batches = 0; batches < 2; batches++) { /* first with few paths, in a list, then with many */
        look_around(render, 7 * batches, 5000);
        rnd_render_resolve(render, NULL, film.samples, NULL);
        for (int level = 1; level < 3; level++) check_level(render, level, &film);
    }
    rnd_render_destroy(render);
}

/* A block's planes are the sum over its pixels. */
static void blocks(void **state)
{
    (void)state;
    struct rnd_render *render = make_with(room, &shows_planes, WIDTH, "fv", 2);
    const struct rnd_film *film = &render->film;
    look_around(render, 7, 5000);
    float values[RND_TILE_PIXELS * 16], sum[16], of_block[16];
    struct rnd_sums sums;
    struct rnd_tile tile;
    assert_int_equal(film->planes.channels, 11);
    for (int t = 0; t < TILES; t++) {
        assert_true(rnd_film_sums(film, 0, t % film->across, t / film->across, &sums, values, &tile));
        for (int b = 0; b < RND_TILE_BLOCKS; b++) {
            const struct rnd_film_block *block = &film->tile[t].block[b];
            memset(sum, 0, sizeof sum);
            memset(of_block, 0, sizeof of_block);
            if (block->visited == 0) continue;
            for (int k = 0; k < RND_BLOCK * RND_BLOCK; k++) {
                const int at = (b / 8 * 8 + k / 8) * RND_TILE + b % 8 * 8 + k % 8;
                for (int c = 0; c < 11; c++) sum[c] += values[at * 11 + c];
            }
            rnd_planes_sum_block(&film->planes, rnd_film_plane_block(film, &film->tile[t], (uint32_t)b),
                                 block->visited, of_block);
            for (int c = 0; c < 10; c++)
                assert_float_equal(of_block[c], sum[c] / (float)block->visited, 1e-4);
        }
    }
    rnd_render_destroy(render);
}

/* --- around a tile --- */

static struct seen all;

/* Every pixel of the window and its margin is that of the picture, which continues across the seam and the
 * poles. */
static bool run_margin(void *memory, const struct rnd_window *window, float *out_rgb)
{
    if (window->side == RND_TILE + 2 * MARGIN)
        for (int y = -MARGIN; y < RND_TILE + MARGIN; y++)
            for (int x = -MARGIN; x < RND_TILE + MARGIN; x++) {
                int to_x = window->x * RND_TILE + x, to_y = window->y * RND_TILE + y;
                if (to_y < 0) to_y = -to_y - 1, to_x += all.width / 2;
                if (to_y >= all.height) to_y = 2 * all.height - 1 - to_y, to_x += all.width / 2;
                to_x = (to_x + all.width) % all.width;
                const float *plane =
                    rnd_window_plane(window, RND_PLANE_POSITION, (y + MARGIN) * window->side + x + MARGIN);
                assert_memory_equal(plane, &all.plane[RND_PLANE_POSITION][3 * (to_y * all.width + to_x)],
                                    3 * sizeof *plane);
            }
    looked_at = RND_PLANE_POSITION;
    return window->side > RND_TILE || run_plane(memory, window, out_rgb);
}

static void margin(void **state)
{
    (void)state;
    static const struct rnd_reconstruction rows[2] = {
        {.name = "tile", .planes = ALL, .run = run_plane},
        {.name = "margin", .planes = RND_PLANE(POSITION), .radius = MARGIN, .run = run_margin}};
    float rgb[RND_TILE * RND_TILE * 3];
    for (int i = 0; i < 2; i++) {
        struct rnd_render *render = make_with(room, &rows[i], WIDTH, "fv", 2);
        look_around(render, 8, 6000);
        if (i == 0) look_at_planes(render, 0, &all);
        for (int t = 0; i == 1 && t < TILES; t++)
            assert_true(
                rnd_render_read(render, 0, t % render->film.across, t / render->film.across, rgb, NULL));
        rnd_render_destroy(render);
    }
}

/* --- memory --- */

static void memory(void **state)
{
    (void)state;
    struct rnd_render *render = make_with(room, NULL, WIDTH, "fv", 2);
    look_around(render, 2, 1000);
    assert_int_equal(render->film.planes.channels, 0);
    assert_null(render->film.plane_memory);
    assert_null(render->film.tile[0].planes);
    assert_null(render->integrator.places.planes);
    rnd_render_destroy(render);

    static const struct {
        uint32_t asked;
        int channels;
        size_t bytes;
    } cases[] = {{0, 0, 0},
                 {RND_PLANE(ALBEDO), 3, 6},
                 {RND_PLANE(NORMAL) | RND_PLANE(INSTANCE), 4, 10},
                 {RND_PLANE(ALBEDO) | RND_PLANE(NORMAL) | RND_PLANE(POSITION) | RND_PLANE(COVERAGE), 10, 26}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rnd_planes planes;
        rnd_planes_init(&planes, cases[i].asked);
        assert_int_equal(planes.channels, cases[i].channels);
        assert_int_equal(planes.bytes, cases[i].bytes);
        const double whole = (double)(sizeof(struct rnd_film_pixels) + sizeof(struct rnd_film_tile) +
                                      rnd_planes_size(&planes, RND_TILE_PIXELS, RND_TILE_BLOCKS)) /
                             RND_TILE_PIXELS;
        print_message("%d channels: %.2f bytes per pixel of the film\n", planes.channels, whole);
        assert_true(whole < 64);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls),  cmocka_unit_test(materials), cmocka_unit_test(threads),
        cmocka_unit_test(levels), cmocka_unit_test(blocks),    cmocka_unit_test(margin),
        cmocka_unit_test(memory),
    };
    return cmocka_run_group_tests_name("renderer_planes", tests, setup, teardown);
}
