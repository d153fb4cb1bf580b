/* The small room: its meshes, images and JSON. One buffer serves all rooms; only the JSON differs. */
#include "room.h"
#include "image.h"
#include "import/image_io.h"

#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_VERTICES = 20000, MAX_TRIANGLES = 24000, BALLS = 16, SIDE = 256 };

struct vertex {
    float position[3], normal[3], uv[2], colour[4];
};

/* The meshes in the buffer, in this order. The balls are where they stand; then come one around the origin
 * and one under the floor. */
enum { FLOOR, WALLS, PANEL = WALLS + 4, MESHED_PANEL, BALL, BALL_AT_ORIGIN = BALL + BALLS, HIDDEN, MESHES };

struct mesh {
    uint32_t first_vertex, vertices, first_triangle, triangles;
};

static struct vertex vertex[MAX_VERTICES];
static uint32_t triangle[MAX_TRIANGLES][3];
static uint32_t vertices, triangles;
static struct mesh mesh[MESHES];

/* --- geometry --- */

/* A surface over u, v in [0,1]: computes position and normal from the parameters p. */
typedef void surface(const float *p, float u, float v, struct vertex *to);

/* p: a corner, and two edges that start there. */
static void flat(const float *p, float u, float v, struct vertex *to)
{
    const float *a = p + 3, *b = p + 6;
    const float n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++) {
        to->position[i] = p[i] + u * a[i] + v * b[i];
        to->normal[i] = n[i] / length;
    }
}

/* Flat and level, with bumps of 8 cm. */
static void bumpy(const float *p, float u, float v, struct vertex *to)
{
    flat(p, u, v, to);
    const float x = 5 * to->position[0], z = 4 * to->position[2],
                slope[2] = {0.2f * cosf(x) * cosf(z), -0.16f * sinf(x) * sinf(z)};
    const float length = sqrtf(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    to->position[1] += 0.04f * sinf(x) * cosf(z);
    to->normal[0] = -slope[0] / length;
    to->normal[1] = 1 / length;
    to->normal[2] = -slope[1] / length;
}

/* p: centre, radius. */
static void ball(const float *p, float u, float v, struct vertex *to)
{
    const float azimuth = 2 * (float)M_PI * u, polar = (float)M_PI * v;
    const float direction[3] = {sinf(polar) * cosf(azimuth), cosf(polar), sinf(polar) * sinf(azimuth)};
    for (int i = 0; i < 3; i++) {
        to->normal[i] = direction[i];
        to->position[i] = p[i] + p[3] * direction[i];
    }
}

/* Add a triangle that faces the way of its first normal. `area` is twice its area as a vector. */
static void add_triangle(uint32_t a, uint32_t b, uint32_t c)
{
    const float *p = vertex[a].position, *q = vertex[b].position, *r = vertex[c].position;
    float area[3], along = 0, square = 0;
    for (int i = 0, j = 1, k = 2; i < 3; j = k, k = i++) {
        area[i] = (q[j] - p[j]) * (r[k] - p[k]) - (q[k] - p[k]) * (r[j] - p[j]);
        along += area[i] * vertex[a].normal[i];
        square += area[i] * area[i];
    }
    if (square < 1e-12f) return; /* at a ball's pole */
    const uint32_t turned[3] = {a, along < 0 ? c : b, along < 0 ? b : c};
    memcpy(triangle[triangles++], turned, sizeof turned);
}

static void add_mesh(int which, surface *shape, const float *p, int columns, int rows)
{
    const uint32_t first = vertices, first_triangle = triangles;
    for (int y = 0; y <= rows; y++)
        for (int x = 0; x <= columns; x++) {
            struct vertex *to = &vertex[vertices++];
            const float u = (float)x / (float)columns, v = (float)y / (float)rows;
            shape(p, u, v, to);
            to->uv[0] = 4 * u;
            to->uv[1] = 4 * v;
            for (int i = 0; i < 3; i++) to->colour[i] = 0.75f + 0.25f * sinf(8 * u + 5 * v + (float)i);
            to->colour[3] = 1;
        }
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            const uint32_t a = (uint32_t)(y * (columns + 1) + x), b = a + (uint32_t)columns + 1;
            add_triangle(a + first, b + first, a + 1 + first);
            add_triangle(a + 1 + first, b + first, b + 1 + first);
        }
    for (uint32_t t = first_triangle; t < triangles; t++) /* indices count from the mesh's first vertex */
        for (int i = 0; i < 3; i++) triangle[t][i] -= first;
    mesh[which] = (struct mesh){first, vertices - first, first_triangle, triangles - first_triangle};
}

static void place_ball(int i, float out[3])
{
    const float angle = 2 * (float)M_PI * (float)i / BALLS;
    out[0] = 2.2f * cosf(angle);
    out[1] = i % 2 ? 0.6f : 1.7f;
    out[2] = 2.2f * sinf(angle);
}

static void build(void)
{
    static const float ground[] = {-3.1f, 0, -3.1f, 0, 0, 6.2f, 6.2f, 0, 0},
                       wall[4][9] = {{-3, -1, -3, 6, 0, 0, 0, 4, 0},
                                     {3, -1, 3, -6, 0, 0, 0, 4, 0},
                                     {-3, -1, 3, 0, 0, -6, 0, 4, 0},
                                     {3, -1, -3, 0, 0, 6, 0, 4, 0}},
                       above[] = {-0.75f, 3, -0.75f, 1.5f, 0, 0, 0, 0, 1.5f}, origin[] = {0, 0, 0, 0.4f},
                       below[] = {0, -0.6f, 0, 0.4f};
    vertices = triangles = 0;
    add_mesh(FLOOR, bumpy, ground, 32, 32);
    for (int i = 0; i < 4; i++) add_mesh(WALLS + i, flat, wall[i], 8, 8);
    add_mesh(PANEL, flat, above, 2, 3);
    add_mesh(MESHED_PANEL, flat, above, 50, 100);
    for (int i = 0; i < BALLS; i++) {
        float p[4] = {0, 0, 0, 0.4f};
        place_ball(i, p);
        add_mesh(BALL + i, ball, p, 16, 12);
    }
    add_mesh(BALL_AT_ORIGIN, ball, origin, 16, 12);
    add_mesh(HIDDEN, ball, below, 16, 12);
}

/* --- files --- */

static const char *path_of(const char *directory, const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

/* 0 colours, with alpha 0 in holes; 1 roughness and metal; 2 normals. */
enum { COLOURS, METAL_ROUGH, NORMALS, IMAGES };
static const char *const image_name[IMAGES] = {"colours.png", "metal_rough.png", "normals.png"};

static void paint(int image, int x, int y, float out[4])
{
    const float s = sinf((float)x * 0.2f), t = sinf((float)y * 0.15f);
    const float n[3] = {0.4f * s, 0.4f * t, 1}, length = sqrtf(1 + 0.16f * (s * s + t * t));
    for (int i = 0; i < 3; i++) {
        if (image == COLOURS) out[i] = 0.7f + 0.15f * (i == 1 ? s * t : s);
        if (image == NORMALS) out[i] = 0.5f + 0.5f * n[i] / length;
    }
    if (image == METAL_ROUGH) out[0] = 0, out[1] = 0.5f + 0.2f * t, out[2] = s * t > 0.5f;
    out[3] = image == COLOURS && s * s + t * t < 0.25f ? 0 : 1;
}

/* Close a file. It is not written under another name first: its folder belongs to this program and is removed
 * at the end. */
static bool close_written(FILE *file, const char *directory, const char *name, char *out_error)
{
    bool ok = file && !ferror(file);
    if (file && fclose(file) != 0) ok = false;
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%s: cannot be written", path_of(directory, name));
    return ok;
}

static float pixel[SIDE * SIDE][4]; /* of the picture that is being written */

static void fill_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    (void)source;
    memcpy(out_pixels, pixel[first * SIDE], (size_t)(count * SIDE) * sizeof *pixel);
}

static bool write_images(const char *directory, char *out_error)
{
    static const struct rnd_layout rgba = {
        .width = SIDE,
        .height = SIDE,
        .channels = 4,
        .channel = {{"R", RND_BYTE}, {"G", RND_BYTE}, {"B", RND_BYTE}, {"A", RND_BYTE}},
        .format = "png"};
    static float sky[32][64][3];
    struct rnd_pixels_source source = {fill_rows};
    for (int k = 0; k < IMAGES; k++) {
        for (int i = 0; i < SIDE * SIDE; i++) paint(k, i % SIDE, i / SIDE, pixel[i]);
        FILE *file = fopen(path_of(directory, image_name[k]), "wb");
        bool ok = file && rnd_pixels_write(file, &rgba, &source, out_error, RND_ERROR_SIZE);
        if (!close_written(file, directory, image_name[k], out_error) || !ok) return false;
    }
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 64; x++)
            for (int i = 0; i < 3; i++)
                sky[y][x][i] = 1 + 0.2f * sinf((float)x * 2 * (float)M_PI / 64) + 0.1f * (float)i;
    return dmn_image_write(path_of(directory, "sky.exr"), 0666, 64, 32, sky[0][0], true, out_error);
}

bool room_prepare(const char *directory, char out_error[RND_ERROR_SIZE])
{
    build();
    FILE *file = fopen(path_of(directory, "room.bin"), "wb");
    if (file) {
        fwrite(vertex, sizeof *vertex, vertices, file);
        fwrite(triangle, sizeof *triangle, triangles, file);
    }
    return close_written(file, directory, "room.bin", out_error) && write_images(directory, out_error);
}

void room_remove(const char *directory)
{
    static const char *const other[] = {"room.bin", "room.gltf", "sky.exr"};
    for (int i = 0; i < IMAGES; i++) unlink(path_of(directory, image_name[i]));
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) unlink(path_of(directory, other[i]));
    rmdir(directory);
}

/* --- JSON --- */

static json_t *quoted(const char *text)
{
    char copy[2048];
    snprintf(copy, sizeof copy, "%s", text);
    for (char *c = copy; *c; c++)
        if (*c == '\'') *c = '"';
    return json_loads(copy, 0, NULL);
}

/* Five accessors per mesh: position, normal, uv, colour, index. */
static json_t *accessors(void)
{
    static const size_t offset[4] = {offsetof(struct vertex, position), offsetof(struct vertex, normal),
                                     offsetof(struct vertex, uv), offsetof(struct vertex, colour)};
    static const char *const type[4] = {"VEC3", "VEC3", "VEC2", "VEC4"};
    json_t *list = json_array();
    for (int m = 0; m < MESHES; m++) {
        const struct mesh *of = &mesh[m];
        float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (uint32_t v = of->first_vertex; v < of->first_vertex + of->vertices; v++)
            for (int i = 0; i < 3; i++) {
                low[i] = fminf(low[i], vertex[v].position[i]);
                high[i] = fmaxf(high[i], vertex[v].position[i]);
            }
        for (int i = 0; i < 4; i++) {
            json_t *one = json_pack("{s:i,s:i,s:i,s:s,s:I}", "bufferView", 0, "componentType", 5126, "count",
                                    (int)of->vertices, "type", type[i], "byteOffset",
                                    (json_int_t)(of->first_vertex * sizeof *vertex + offset[i]));
            if (i == 0)
                json_object_update_new(one, json_pack("{s:[f,f,f],s:[f,f,f]}", "min", (double)low[0],
                                                      (double)low[1], (double)low[2], "max", (double)high[0],
                                                      (double)high[1], (double)high[2]));
            json_array_append_new(list, one);
        }
        json_array_append_new(list,
                              json_pack("{s:i,s:i,s:i,s:s,s:I}", "bufferView", 1, "componentType", 5125,
                                        "count", (int)(3 * of->triangles), "type", "SCALAR", "byteOffset",
                                        (json_int_t)(of->first_triangle * sizeof *triangle)));
    }
    return list;
}

static bool has_surface(const struct room *room, int m)
{
    const bool is_ball = m >= BALL && m <= BALL_AT_ORIGIN;
    switch (room->parts) {
    case ROOM_ALL:
        return m != MESHED_PANEL;
    case ROOM_BALLS:
        return is_ball;
    case ROOM_PANEL:
        return m == PANEL;
    case ROOM_MESHED_PANEL:
        return m == MESHED_PANEL;
    case ROOM_HIDDEN:
        return m == HIDDEN;
    default:
        return false;
    }
}

/* The meshes of the buffer under their numbers, and one more, with the surface. */
static json_t *meshes(const struct room *room)
{
    json_t *list = json_array();
    for (int m = 0; m <= MESHES; m++) {
        const bool other = m == MESHES || has_surface(room, m);
        const int a = 5 * (m < MESHES ? m : HIDDEN);
        json_t *attributes = json_pack("{s:i,s:i,s:i}", "POSITION", a, "NORMAL", a + 1, "TEXCOORD_0", a + 2);
        if (other && room->surface.colours) json_object_set_new(attributes, "COLOR_0", json_integer(a + 3));
        json_array_append_new(list, json_pack("{s:[{s:o,s:i,s:i}]}", "primitives", "attributes", attributes,
                                              "indices", a + 4, "material", other));
    }
    if (room->parts != ROOM_UNUSED) json_array_remove(list, MESHES);
    return list;
}

static json_t *nodes(const struct room *room)
{
    json_t *list = json_pack("[{s:i,s:[f,f,f]}]", "camera", 0, "translation", 0.0, 1.5, 0.0);
    for (int m = 0; m < MESHES; m++) {
        const bool placed = m >= BALL && m < BALL + BALLS && room->instances;
        if (m == BALL_AT_ORIGIN || m == (room->parts == ROOM_MESHED_PANEL ? PANEL : MESHED_PANEL)) continue;
        json_t *node = json_pack("{s:i}", "mesh", placed ? BALL_AT_ORIGIN : m);
        if (placed) {
            float p[3];
            place_ball(m - BALL, p);
            json_object_set_new(node, "translation",
                                json_pack("[f,f,f]", (double)p[0], (double)p[1], (double)p[2]));
        }
        json_array_append_new(list, node);
    }
    for (int i = 0; i < 3 && room->punctual == ROOM_ALL; i++)
        json_array_append_new(list, json_pack("{s:[f,f,f],s:{s:{s:i}}}", "translation", i - 1.0, 2.5, 0.5 * i,
                                              "extensions", "KHR_lights_punctual", "light", i));
    return list;
}

static json_t *room_json(const struct room *room)
{
    json_t *in_scene = json_array(), *all = nodes(room), *materials = json_array();
    for (size_t i = 0; i < json_array_size(all); i++)
        json_array_append_new(in_scene, json_integer((json_int_t)i));
    json_array_append_new(materials, quoted(room->plain));
    if (room->surface.material) json_array_append_new(materials, quoted(room->surface.material));
    json_t *root = json_pack("{s:{s:s},s:i,s:[{s:o}],s:o,s:[{s:s,s:{s:f,s:f}}],s:o,s:o,s:o}", "asset",
                             "version", "2.0", "scene", 0, "scenes", "nodes", in_scene, "nodes", all,
                             "cameras", "type", "perspective", "perspective", "yfov", 1.0, "znear", 0.1,
                             "meshes", meshes(room), "materials", materials, "accessors", accessors());
    const int bytes = (int)(vertices * sizeof *vertex), indices = (int)(triangles * sizeof *triangle);
    json_object_update_new(root,
                           json_pack("{s:[{s:s,s:i}],s:[{s:i,s:i,s:i},{s:i,s:i,s:i}]}", "buffers", "uri",
                                     "room.bin", "byteLength", bytes + indices, "bufferViews", "buffer", 0,
                                     "byteLength", bytes, "byteStride", (int)sizeof *vertex, "buffer", 0,
                                     "byteOffset", bytes, "byteLength", indices));
    json_object_update_new(root,
                           json_pack("{s:[{s:s},{s:s},{s:s}],s:[{s:i},{s:i},{s:i}]}", "images", "uri",
                                     image_name[COLOURS], "uri", image_name[METAL_ROUGH], "uri",
                                     image_name[NORMALS], "textures", "source", 0, "source", 1, "source", 2));
    if (room->punctual != ROOM_NOTHING)
        json_object_set_new(
            root, "extensions",
            quoted("{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':5},"
                   "{'type':'point','intensity':5},{'type':'spot','spot':{},'intensity':9}]}}"));
    return root;
}

struct rnd_scene *room_load(const char *directory, const struct room *room, bool sun,
                            char out_error[RND_ERROR_SIZE])
{
    char path[256], sky[256];
    snprintf(path, sizeof path, "%s", path_of(directory, "room.gltf"));
    snprintf(sky, sizeof sky, "%s", path_of(directory, "sky.exr"));
    json_t *root = room_json(room);
    const bool ok = root && json_dump_file(root, path, JSON_COMPACT) == 0;
    json_decref(root);
    if (!ok) {
        snprintf(out_error, RND_ERROR_SIZE, "%s: cannot be written", path);
        return NULL;
    }
    const struct rnd_scene_options options = {
        .path = path, .env_path = sky, .has_sun = sun, .sun = {40, 50, 3, 0.5f}};
    return rnd_scene_load(&options, out_error);
}
