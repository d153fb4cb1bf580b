/* The packed corners of triangles, made after import from the arrays of the meshes. */
#include "import/corners.h"
#include "math/large_pages.h"

#include <stdlib.h>

static struct rnd_v3 corner(const float *attribute, uint32_t i)
{
    return rnd_v3(attribute[3 * (size_t)i], attribute[3 * (size_t)i + 1], attribute[3 * (size_t)i + 2]);
}

static uint32_t colour(const float *rgba)
{
    uint32_t code = 0;
    for (int c = 0; c < 3; c++) {
        const float value = sqrtf(fmaxf(0.0f, fminf(rgba[c], 1.0f)));
        code |= (uint32_t)(value * 1023.0f + 0.5f) << 10 * c;
    }
    return code;
}

/* Texture coordinates, their density, and their tangent on the triangle. */
static void make_uv(struct rnd_corners *corners, const float *uv, const uint32_t index[3], struct rnd_v3 e1,
                    struct rnd_v3 e2)
{
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 2; c++) corners->uv[k][c] = uv[2 * (size_t)index[k] + c];
    const struct rnd_uv_frame frame = rnd_uv_frame((const float(*)[2])corners->uv, e1, e2);
    if (!frame.spans) return;
    corners->lod = frame.lod;
    for (int k = 0; k < 3; k++) corners->tangent[k] = (rnd_octahedral(frame.along) & ~1u) | frame.mirrored;
}

/* Take the file's tangents, whose w is the side of the bitangent: up in the picture, against v. */
static void take_tangents(struct rnd_corners *corners, const float *tangent, const uint32_t index[3])
{
    for (int k = 0; k < 3; k++) {
        const float *t = tangent + 4 * (size_t)index[k];
        corners->tangent[k] = (rnd_octahedral(rnd_v3(t[0], t[1], t[2])) & ~1u) | (t[3] > 0.0f);
    }
}

static void make(const struct rnd_mesh *mesh, uint32_t triangle, struct rnd_corners *corners)
{
    const uint32_t *index = mesh->index[triangle];
    const struct rnd_v3 a = corner(mesh->position, index[0]);
    const struct rnd_v3 e1 = rnd_v3_sub(corner(mesh->position, index[1]), a),
                        e2 = rnd_v3_sub(corner(mesh->position, index[2]), a), normal = rnd_v3_cross(e1, e2);
    *corners = (struct rnd_corners){.lod = RND_NO_EXTENT};
    for (int k = 0; k < 3; k++) {
        corners->normal[k] = rnd_octahedral(mesh->normal ? corner(mesh->normal, index[k]) : normal);
        corners->colour[k] = mesh->colour ? colour(mesh->colour + 4 * (size_t)index[k]) : UINT32_MAX;
    }
    if (mesh->uv[0]) make_uv(corners, mesh->uv[0], index, e1, e2);
    if (mesh->tangent) take_tangents(corners, mesh->tangent, index);
}

bool rnd_corners_build(struct rnd_scene *scene)
{
    uint64_t count = 0;
    for (uint32_t m = 0; m < scene->mesh_count; m++) {
        scene->mesh[m].first_corners = count;
        count += scene->mesh[m].triangles;
    }
    scene->corners = aligned_alloc(64, (count + 1) * sizeof *scene->corners);
    if (!scene->corners) return false;
    rnd_use_large_pages(scene->corners, count * sizeof *scene->corners);
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        for (uint32_t t = 0; t < scene->mesh[m].triangles; t++)
            make(&scene->mesh[m], t, &scene->corners[scene->mesh[m].first_corners + t]);
    return true;
}
