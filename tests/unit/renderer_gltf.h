/* Load glTF files in tests, and expect no warning, a warning, or an error. */
#ifndef FOVEAD_TESTS_RENDERER_GLTF_H
#define FOVEAD_TESTS_RENDERER_GLTF_H

#include "renderer_parts.h"

static const char node[] = "{\"mesh\":0}", shining[] = "{\"emissiveFactor\":[1,1,1]}";

#define VEC3(n)               "\"componentType\":5126,\"count\":" #n ",\"type\":\"VEC3\""
#define SCALARS(component, n) "\"componentType\":" #component ",\"count\":" #n ",\"type\":\"SCALAR\""

/* Load a scene that must not cause a warning. */
static inline struct rnd_scene *load_quietly(const char *path)
{
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    assert_string_equal(rnd_scene_info(scene)->warnings, "");
    assert_string_equal(rnd_scene_info(scene)->unsupported, "");
    return scene;
}

/* Load a scene whose warnings must contain these words. */
static inline struct rnd_scene *load_warned(const char *path, const char *words)
{
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    if (!strstr(rnd_scene_info(scene)->warnings, words))
        fail_msg("\"%s\": expected %s", rnd_scene_info(scene)->warnings, words);
    return scene;
}

static inline void assert_refused(const char *path, const char *words)
{
    const struct rnd_scene_options options = {
        .image_program = files_image_program(), .path = path, .env_path = files_env("env.exr", 1)};
    char error[RND_ERROR_SIZE] = "";
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (scene || !strstr(error, words) || strchr(error, '\n'))
        fail_msg("\"%s\": expected %s", scene ? "loaded" : error, words);
    assert_non_null(strstr(error, strrchr(path, '/') + 1));
}

#endif
