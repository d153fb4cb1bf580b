/* Writing a scene into one piece of memory. */
#include "import/flat_put.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct put {
    int fd;
    uint64_t at;
    bool ok;
};

enum { ALIGN = 16 };

static void write_all(struct put *put, const void *bytes, size_t count)
{
    const char *from = bytes;
    while (put->ok && count > 0) {
        const ssize_t n = write(put->fd, from, count);
        if (n < 0 && errno == EINTR) continue;
        if (!(put->ok = n > 0)) return;
        from += n;
        count -= (size_t)n;
        put->at += (uint64_t)n;
    }
}

/* Append bytes, then zeros up to a multiple of ALIGN, one float of them at least (Embree's wide loads).
 * Returns where the bytes are. */
static uint64_t put_bytes(struct put *put, const void *bytes, size_t count)
{
    static const char zeros[2 * ALIGN];
    const uint64_t at = put->at;
    if (!bytes) return 0;
    write_all(put, bytes, count);
    write_all(put, zeros, 2 * ALIGN - put->at % ALIGN);
    return at;
}

static uint64_t put_text(struct put *put, const char *text)
{
    return put_bytes(put, text ? text : "", text ? strlen(text) + 1 : 1);
}

static struct rnd_flat_list put_list(struct put *put, const void *list, size_t count, size_t size)
{
    return (struct rnd_flat_list){put_bytes(put, list, count * size), list ? count : 0};
}

static struct rnd_flat_mesh put_mesh(struct put *put, const struct rnd_mesh *mesh)
{
    const size_t n = mesh->vertices * sizeof(float);
    return (struct rnd_flat_mesh){
        .vertices = mesh->vertices,
        .triangles = mesh->triangles,
        .material = mesh->material,
        .instanced = mesh->instanced,
        .position = put_bytes(put, mesh->position, 3 * n),
        .normal = put_bytes(put, mesh->normal, 3 * n),
        .uv = {put_bytes(put, mesh->uv[0], 2 * n), put_bytes(put, mesh->uv[1], 2 * n)},
        .colour = put_bytes(put, mesh->colour, 4 * n),
        .tangent = put_bytes(put, mesh->tangent, 4 * n),
        .index = put_bytes(put, mesh->index, mesh->triangles * sizeof *mesh->index)};
}

/* Write all meshes, each of which is then freed. */
static void put_meshes(struct put *put, struct rnd_scene *scene, struct rnd_flat_list *out)
{
    struct rnd_flat_mesh *mesh = calloc(scene->mesh_count + 1, sizeof *mesh);
    put->ok = put->ok && mesh;
    for (uint32_t i = 0; put->ok && i < scene->mesh_count; i++) {
        mesh[i] = put_mesh(put, &scene->mesh[i]);
        rnd_mesh_finish(&scene->mesh[i]);
        scene->mesh[i] = (struct rnd_mesh){0};
    }
    *out = put_list(put, mesh, scene->mesh_count, sizeof *mesh);
    free(mesh);
}

static void put_textures(struct put *put, const struct rnd_scene *scene, struct rnd_flat_list *out)
{
    struct rnd_flat_texture *texture = calloc(scene->texture_count + 1, sizeof *texture);
    put->ok = put->ok && texture;
    for (uint32_t i = 0; put->ok && i < scene->texture_count; i++) {
        const struct rnd_texture *from = &scene->texture[i];
        texture[i] = (struct rnd_flat_texture){.use = from->use,
                                               .path = put_text(put, from->path),
                                               .file = put_list(put, from->file, from->file_bytes, 1)};
    }
    *out = put_list(put, texture, scene->texture_count, sizeof *texture);
    free(texture);
}

bool rnd_flat_put(struct rnd_scene *scene, int fd)
{
    struct put put = {.fd = fd, .ok = true};
    struct rnd_flat_head head = {.magic = RND_FLAT_MAGIC, .layout = rnd_flat_layout()};
    put_bytes(&put, &head, sizeof head); /* room for the head, which is written last */
    put_meshes(&put, scene, &head.mesh);
    put_textures(&put, scene, &head.texture);
    head.material = put_list(&put, scene->material, scene->material_count, sizeof *scene->material);
    head.instance = put_list(&put, scene->instance, scene->instance_count, sizeof *scene->instance);
    head.punctual =
        put_list(&put, scene->lights.punctual, scene->lights.punctual_count, sizeof *scene->lights.punctual);
    head.files = put_list(&put, scene->files.text, scene->files.size, 1);
    head.warnings = put_text(&put, scene->warnings.text);
    head.unsupported = put_text(&put, scene->unsupported);
    memcpy(head.camera, scene->info.camera, sizeof head.camera);
    memcpy(head.bounds, scene->info.bounds, sizeof head.bounds);
    memcpy(head.origin, scene->origin, sizeof head.origin);
    return put.ok && pwrite(fd, &head, sizeof head, 0) == (ssize_t)sizeof head;
}
