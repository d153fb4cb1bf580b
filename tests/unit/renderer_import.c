/* Scene files: unusable ones are refused with one line that names the file; others are read as their format
 * requires. */
#include "renderer_files.h"

#include <dirent.h>
#include <ftw.h>
#include <sys/stat.h>

#include <assimp/cexport.h>
#include <assimp/cimport.h>
#include <assimp/scene.h>

/* --- refused --- */

/* The scene must be refused with one line that names the file at fault and contains a word on the cause. */
static void assert_refused_with(const char *path, const char *env, const char *file, const char *cause)
{
    const struct rnd_scene_options options = {
        .image_program = files_image_program(), .path = path, .env_path = env};
    char error[RND_ERROR_SIZE] = "";
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    rnd_scene_destroy(scene);
    print_message("%s\n", scene ? "loaded" : error);
    assert_null(scene);
    assert_non_null(strstr(error, file));
    assert_non_null(strstr(error, cause));
    assert_null(strchr(error, '\n'));
    assert_null(strchr(error, '\r'));
}

static void assert_refused(const char *path, const char *cause)
{
    assert_refused_with(path, files_env("env.exr", 1), strrchr(path, '/') + 1, cause);
}

static const char node[] = "{\"mesh\":0}", grey[] = "{}", shining[] = "{\"emissiveFactor\":[1,1,1]}";

static void not_there(void **state)
{
    (void)state;
    assert_refused(files_path("missing.gltf"), "No such file");
    assert_refused(files_path("missing.obj"), "No such file");
    assert_int_equal(mkdir(files_path("folder.gltf"), 0700), 0);
    assert_refused(files_path("folder.gltf"), "");
    assert_int_equal(mkdir(files_path("folder"), 0700), 0);
    assert_refused(files_path("folder"), "");
}

static void broken(void **state)
{
    (void)state;
    assert_refused(files_text("empty.gltf", ""), "");
    assert_refused(files_text("empty.glb", ""), "");
    assert_refused(files_text("empty.obj", ""), "");
    assert_refused(files_text("noise.gltf", "\x7f\x45\x4c\x46 what is this"), "");
    assert_refused(files_text("noise.xyz", "what is this"), "");
    assert_refused(files_text("braces.gltf", "{}"), "");
    assert_refused(files_text("list.gltf", "[]"), "");
    assert_refused(files_text("header.glb", "glTF\2\0\0\0"), "");

    /* A good file that is cut before its JSON ends, and a .glb that is cut anywhere. */
    static char text[100000];
    FILE *file = fopen(files_gltf("whole.gltf", 1, node, shining, ""), "rb");
    assert_non_null(file);
    const size_t length = fread(text, 1, sizeof text, file);
    fclose(file);
    for (size_t cut = 1; cut < length - 2; cut += cut < length - 40 ? 97 : 1)
        assert_refused(files_write("cut.gltf", text, cut), "");

    file = fopen(files_glb("whole.glb", 1, node, shining, ""), "rb");
    assert_non_null(file);
    const size_t all = fread(text, 1, sizeof text, file);
    fclose(file);
    for (size_t cut = 1; cut < all; cut += cut < all - 130 ? 61 : 1)
        assert_refused(files_write("cut.glb", text, cut), "");
}

static void parts_absent(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE];
    assert_refused(
        files_text("buffer.gltf",
                   "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                   "{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                   "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
                   "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
                   "\"uri\":\"nowhere.bin\"}]}"),
        "nowhere.bin");
    assert_refused(files_text("nodes.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{}]}"),
                   "");
    assert_refused(files_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "");
    assert_refused(files_text("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n"), "triangle");
    const char *dark = files_gltf("dark.gltf", 1, node, grey, "");
    assert_refused_with(dark, NULL, "dark.gltf", "light");

    files_text("text.png", "this is not a picture");
    const char *good = files_gltf("good.gltf", 1, node, shining, "");
    assert_refused_with(good, files_path("gone.hdr"), "gone.hdr", "not a readable image");
    assert_refused_with(good, files_path("text.png"), "text.png", "not a readable image");
    float rgb[64 * 32 * 3] = {0};
    assert_true(files_image(files_path("black.exr"), 64, 32, rgb, true, error));
    assert_refused_with(good, files_path("black.exr"), "black.exr", "black");
}

/* How often a word occurs in a text. */
static int times(const char *text, const char *word)
{
    int count = 0;
    for (; (text = strstr(text, word)); text += strlen(word)) count++;
    return count;
}

/* A scene that lacks one of its images: a warning names the file, and the material's factors apply without
 * the image. */
static void images_absent(void **state)
{
    (void)state;
    static const char picture[] =
        "{\"emissiveFactor\":[0.5,0.5,0.5],\"emissiveTexture\":{\"index\":0},\"alphaMode\":\"MASK\","
        "\"normalTexture\":{\"index\":0},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1],"
        "\"baseColorTexture\":{\"index\":0}}}";
    static const char *const uris[] = {"text.png", "gone.png", "data:image/png;base64,AAAAAAAAAAAAAAAA",
                                       "data:image/png;base64,???"};
    static const char *const named[] = {"text.png: ", "gone.png: ", "inside.gltf: ", "inside.gltf: "};
    const struct rnd_aim down = files_aim(0, -1, 0);
    files_text("text.png", "this is not a picture");
    for (int i = 0; i < 8; i++) {
        char more[400], error[RND_ERROR_SIZE];
        snprintf(more, sizeof more, ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"%s\"}]",
                 uris[i / 2]);
        const struct rnd_scene_options options = {.image_program = files_image_program(),
                                                  .path = files_gltf("inside.gltf", 10, node, picture, more),
                                                  .env_path = files_env("env.exr", 1),
                                                  .textures_later = i % 2,
                                                  .has_camera = true,
                                                  .camera = {0, 1, 0}};
        struct rnd_scene *scene = rnd_scene_load(&options, error);
        if (!scene) fail_msg("%s", error);
        const char *lines = rnd_scene_info(scene)->warnings, *late;
        while (rnd_scene_take_textures(scene, &late) == RND_TEXTURES_READING) continue;
        print_message("%s%s", lines, late);
        assert_int_equal(times(lines, named[i / 2]) + times(late, named[i / 2]), 1);
        assert_int_equal(times(lines, "\n") + times(late, "\n"), 1);
        assert_float_equal(files_radiance(scene, "fv", 1, 20000, &down, 30, NULL), 0.5, 0.01);
        rnd_scene_destroy(scene);
    }
    files_text("gone.mtl", "newmtl m\nKd 0.25 0.25 0.25\nmap_Kd gone.jpg\nmap_d gone.jpg\n");
    struct rnd_scene *scene = files_load(
        files_text("gone.obj", "mtllib gone.mtl\nusemtl m\nv -9 0 -9\nv 0 0 9\nv 9 0 -9\nf 1 2 3\n"),
        files_env("env.exr", 1), NULL, (float[]){0, 1, -3});
    assert_int_equal(times(rnd_scene_info(scene)->warnings, "gone.jpg: "), 1);
    assert_int_equal(times(rnd_scene_info(scene)->warnings, "\n"), 1);
    assert_float_equal(files_radiance(scene, "fv", 0, 20000, &down, 30, NULL), 0.25, 0.005);
    rnd_scene_destroy(scene);
}

/* A glTF whose third vertex has this x coordinate. */
static const char *with_coordinate(const char *name, float x)
{
    static char text[91000];
    const float vertex[9] = {0, 0, 0, 1, 0, 0, x, 1, 0};
    snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"materials\":[{\"emissiveFactor\":[1,1,1]}],\"meshes\":[{\"name\":\"flag\",\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0},\"material\":0}]}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{"
        "\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,%s\"}]}",
        files_base64(vertex, sizeof vertex));
    return files_text(name, text);
}

static void not_finite(void **state)
{
    (void)state;
    assert_refused(with_coordinate("nan.gltf", NAN), "vertex 2");
    assert_refused(with_coordinate("infinite.gltf", INFINITY), "vertex 2");
    assert_refused(with_coordinate("far.gltf", 1e30f), "vertex 2"); /* the triangle's area overflows */
    assert_refused(files_text("nan.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n"), "vertex");
    assert_refused(files_text("infinite.obj", "v 0 0 0\nv 1 0 0\nv 1e39 1 0\nf 1 2 3\n"), "vertex");
    assert_refused(files_gltf("scale.gltf", 1, "{\"mesh\":0,\"scale\":[1e38,1e38,1e38]}", shining, ""),
                   "vertex");
    assert_refused(
        files_gltf("bright.gltf", 1, node,
                   "{\"emissiveFactor\":[1,1,1],\"extensions\":{\"KHR_materials_emissive_strength\":{"
                   "\"emissiveStrength\":1e39}}}",
                   ",\"extensionsUsed\":[\"KHR_materials_emissive_strength\"]"),
        "bright");
    assert_refused(
        files_gltf("power.gltf", 1000, node,
                   "{\"emissiveFactor\":[1,1,1],\"extensions\":{\"KHR_materials_emissive_strength\":{"
                   "\"emissiveStrength\":3e38}}}",
                   ",\"extensionsUsed\":[\"KHR_materials_emissive_strength\"]"),
        "bright");
}

/* Hostile files: a reader that trusts one of them would run out of memory, stack or time. */
static void hostile(void **state)
{
    (void)state;
    static char text[400000], whole[500000];
    /* Node 1 holds the mesh. Each of the 40 nodes after it has its predecessor as a child twice: 2^40 meshes.
     */
    size_t n = (size_t)sprintf(text, "{\"children\":[41]},{\"mesh\":0}");
    for (int i = 1; i <= 40; i++) n += (size_t)sprintf(text + n, ",{\"children\":[%d,%d]}", i, i);
    assert_refused(files_gltf("many.gltf", 1, text, shining, ""), "node");
    assert_refused(
        files_gltf("circle.gltf", 1, "{\"mesh\":0,\"children\":[1]},{\"children\":[0]}", shining, ""),
        "node");
    assert_refused(files_gltf("self.gltf", 1, "{\"mesh\":0,\"children\":[0]}", shining, ""), "node");
    assert_refused(files_gltf("nobody.gltf", 1, "{\"mesh\":0,\"children\":[7]}", shining, ""), "node");
    assert_refused(files_gltf("mesh.gltf", 1, "{\"mesh\":9}", shining, ""), "");

    memset(text, '[', sizeof text - 1);
    assert_refused(files_write("deep.gltf", text, sizeof text - 1), "");
    n = 0; /* a chain of nodes */
    for (int i = 0; i < 10000; i++) n += (size_t)sprintf(text + n, "{\"children\":[%d]},", i + 1);
    sprintf(text + n, "{\"mesh\":0}");
    snprintf(whole, sizeof whole,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[%s]}",
             text);
    assert_refused(files_text("chain.gltf", whole), "");
}

/* --- accepted --- */

static double seen_from(const char *path, float x, float y, float z, const struct rnd_aim *aim, double cone,
                        float rgb[3])
{
    struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){x, y, z});
    const double value = files_radiance(scene, "fv", 1, 20000, aim, cone, rgb);
    rnd_scene_destroy(scene);
    return value;
}

static void emissive_strength(void **state)
{
    (void)state;
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    static const char strong[] =
        "{\"emissiveFactor\":[0.5,0.25,1],\"extensions\":{\"KHR_materials_emissive_strength\":"
        "{\"emissiveStrength\":8}},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]}}",
                      used[] = ",\"extensionsUsed\":[\"KHR_materials_emissive_strength\"]";
    const char *paths[2] = {files_gltf("strong.gltf", 10, node, strong, used),
                            files_glb("strong.glb", 10, node, strong, used)};
    for (int i = 0; i < 2; i++) {
        float rgb[3];
        seen_from(paths[i], 0, 1, 0, &down, 40, rgb);
        assert_float_equal(rgb[0], 4, 1e-4);
        assert_float_equal(rgb[1], 2, 1e-4);
        assert_float_equal(rgb[2], 8, 1e-4);
        assert_true(seen_from(paths[i], 0, -1, 0, &up, 40, NULL) == 0.0); /* emits on one side only */
    }
}

/* Which side of the square emits, after its node's transform. */
static void transforms(void **state)
{
    (void)state;
    static const struct {
        const char *nodes;
        bool up;
    } cases[] = {
        {"{\"mesh\":0}", true},
        {"{\"mesh\":0,\"scale\":[-1,1,1]}", true},
        {"{\"mesh\":0,\"scale\":[1,-1,1]}", false},
        {"{\"mesh\":0,\"scale\":[-2,1,-0.5]}", true},
        {"{\"mesh\":0,\"scale\":[-1,-1,-1]}", false},
        {"{\"mesh\":0,\"rotation\":[1,0,0,0]}", false},
        {"{\"scale\":[-1,1,1],\"children\":[1]},{\"mesh\":0,\"scale\":[-1,1,1]}", true},
        {"{\"scale\":[1,-1,1],\"children\":[1]},{\"mesh\":0,\"rotation\":[0,0,1,0]}", true},
        {"{\"matrix\":[0,0,1,0, 0,1,0,0, 1,0,0,0, 0,0,0,1],\"children\":[1]},{\"mesh\":0}", true},
    };
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = files_gltf("turned.gltf", 10, cases[i].nodes, shining, "");
        const double above = seen_from(path, 0, 1, 0, &down, 20, NULL),
                     below = seen_from(path, 0, -1, 0, &up, 20, NULL);
        assert_float_equal(above, cases[i].up ? 1 : 0, 1e-5);
        assert_float_equal(below, cases[i].up ? 0 : 1, 1e-5);
    }
}

/* FBX files in centimetres and in metres. */
static void units(void **state)
{
    (void)state;
    const struct aiScene *file =
        aiImportFile(files_text("unit.obj", "v 0 0 0\nv 100 0 0\nv 0 0 100\nf 1 3 2\n"), 0);
    assert_non_null(file);
    assert_int_equal(aiExportScene(file, "fbxa", files_path("cm.fbx"), 0), aiReturn_SUCCESS);
    aiReleaseImport(file);
    static char text[100000], changed[100000];
    FILE *from = fopen(files_path("cm.fbx"), "rb");
    assert_non_null(from);
    text[fread(text, 1, sizeof text - 1, from)] = 0;
    fclose(from);
    static const char key[] = "P: \"UnitScaleFactor\", \"double\", \"Number\", \"\", 1";
    const char *at = strstr(text, key);
    assert_non_null(at);
    snprintf(changed, sizeof changed, "%.*s00%s", (int)(at - text + (long)strlen(key)), text,
             at + strlen(key));
    files_text("m.fbx", changed);
    for (int k = 0; k < 2; k++) {
        struct rnd_scene *scene =
            files_load(files_path(k ? "m.fbx" : "cm.fbx"), files_env("white.hdr", 1), NULL, NULL);
        assert_float_equal(rnd_scene_info(scene)->bounds[1][0], k ? 100 : 1, 1e-4);
        assert_float_equal(rnd_scene_info(scene)->bounds[1][2], k ? 100 : 1, 1e-4);
        rnd_scene_destroy(scene);
    }
}

static void camera_and_bounds(void **state)
{
    (void)state;
    const char *nodes = "{\"translation\":[1,2,3],\"scale\":[2,2,2],\"children\":[1,2]},{\"mesh\":0},"
                        "{\"camera\":0,\"translation\":[0.5,-1,0.25]}";
    const char *camera =
        ",\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}]";
    const char *path = files_gltf("camera.gltf", 4, nodes, shining, camera);
    struct rnd_scene *scene = files_load(path, NULL, NULL, NULL);
    const struct rnd_scene_info *info = rnd_scene_info(scene);
    static const float position[3] = {2, 0, 3.5f}, low[3] = {-7, 2, -5}, high[3] = {9, 2, 11};
    for (int c = 0; c < 3; c++) {
        assert_float_equal(info->camera[c], position[c], 1e-5);
        assert_float_equal(info->bounds[0][c], low[c], 1e-5);
        assert_float_equal(info->bounds[1][c], high[c], 1e-5);
    }
    assert_int_equal(info->triangles, 2);
    assert_int_equal(info->emissive_triangles, 2);
    assert_int_equal(info->meshes, 1);
    assert_false(info->has_env || info->has_sun);
    assert_string_equal(info->unsupported, "");
    rnd_scene_destroy(scene);

    scene = files_load(path, NULL, NULL, (float[]){5, 6, 7}); /* the option overrides the file's camera */
    assert_float_equal(rnd_scene_info(scene)->camera[1], 6, 0);
    rnd_scene_destroy(scene);
    scene = files_load(files_gltf("middle.gltf", 4, "{\"mesh\":0,\"translation\":[1,2,3]}", shining, ""),
                       files_env("env.exr", 1), (float[]){0, 45, 1, 0}, NULL);
    for (int c = 0; c < 3; c++) assert_float_equal(rnd_scene_info(scene)->camera[c], c + 1, 1e-5);
    assert_true(rnd_scene_info(scene)->has_env && rnd_scene_info(scene)->has_sun);
    rnd_scene_destroy(scene);
}

/* Write an image of four colours: red and green above, blue and white below. */
static void write_quarters(const char *name)
{
    enum { SIDE = 16 };
    float rgb[SIDE * SIDE * 3];
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        const bool right = i % SIDE >= SIDE / 2, below = i / SIDE >= SIDE / 2;
        rgb[3 * i] = right == below;
        rgb[3 * i + 1] = right;
        rgb[3 * i + 2] = below;
    }
    if (!files_image(files_path(name), SIDE, SIDE, rgb, false, error)) fail_msg("%s", error);
}

/* Seen from above with -Z up, row 0 of the image must lie at -Z and column 0 at -X. */
static void assert_quarters(const char *path, double tolerance)
{
    for (int i = 0; i < 4; i++) {
        const int right = i & 1, below = i >> 1;
        const struct rnd_aim aim = files_aim(right ? 1 : -1, -2, below ? 1 : -1);
        float rgb[3];
        seen_from(path, 0, 2, 0, &aim, 12, rgb);
        assert_float_equal(rgb[0], right == below, tolerance);
        assert_float_equal(rgb[1], right, tolerance);
        assert_float_equal(rgb[2], below, tolerance);
    }
}

static const char *data_uri(const char *name, const char *mime)
{
    static char uri[91000], bytes[40000];
    FILE *file = fopen(files_path(name), "rb");
    assert_non_null(file);
    const size_t length = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    snprintf(uri, sizeof uri, "data:%s;base64,%s", mime, files_base64(bytes, length));
    return uri;
}

static void textures(void **state)
{
    (void)state;
    static const char shows[] = "{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0},"
                                "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]}}";
    static char more[92000];
    write_quarters("quarters.png");
    write_quarters("quarters.jpg");
    write_quarters("with space.png");
    const char *uris[] = {"quarters.png", "quarters.jpg", "with%20space.png", NULL, NULL};
    for (int i = 0; i < 5; i++) {
        const char *uri = i == 3   ? data_uri("quarters.png", "image/png")
                          : i == 4 ? data_uri("quarters.jpg", "image/jpeg")
                                   : uris[i];
        snprintf(more, sizeof more, ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"%s\"}]", uri);
        const char *path = files_gltf("shows.gltf", 2, node, shows, more);
        assert_quarters(path, i == 1 || i == 4 ? 0.05 : 1e-3);
    }
    /* OBJ counts v from the bottom */
    files_text("shows.mtl", "newmtl m\nKd 0 0 0\nKe 1 1 1\nmap_Ke quarters.png\n");
    assert_quarters(files_text("shows.obj",
                               "mtllib shows.mtl\nusemtl m\nv -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\n"
                               "vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3 4/4\n"),
                    1e-3);
    /* OBJ may name files as another machine wrote them. */
    static const char *const names[] = {"QUARTERS.png", "Textures\\Quarters.PNG", "C:\\work\\quarters.png",
                                        "/home/somebody/quarters.png", "none/quarters.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char mtl[200];
        snprintf(mtl, sizeof mtl, "newmtl m\nKd 0 0 0\nKe 1 1 1\nmap_Ke %s\n", names[i]);
        files_text("shows.mtl", mtl);
        struct rnd_scene *scene = files_load(files_path("shows.obj"), NULL, NULL, NULL);
        assert_string_equal(rnd_scene_info(scene)->warnings, "");
        assert_int_equal(rnd_scene_info(scene)->textures, 1);
        rnd_scene_destroy(scene);
    }
}

static void unsupported(void **state)
{
    (void)state;
    const char *path =
        files_gltf("wants.gltf", 1, node,
                   "{\"emissiveFactor\":[1,1,1],\"extensions\":{\"KHR_materials_iridescence\":"
                   "{},\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}}}",
                   ",\"extensionsUsed\":[\"KHR_materials_anisotropy\",\"KHR_materials_variants\"]");
    struct rnd_scene *scene = files_load(path, NULL, NULL, NULL);
    assert_string_equal(rnd_scene_info(scene)->unsupported,
                        "anisotropy, iridescence, variants (the default is shown)");
    rnd_scene_destroy(scene);
}

/* --- files from elsewhere --- */

static int loaded, refused;

static int try_file(const char *path, const struct stat *status, int kind, struct FTW *where)
{
    (void)status, (void)where;
    const char *dot = strrchr(path, '.');
    if (kind != FTW_F || !dot || (strcmp(dot, ".gltf") != 0 && strcmp(dot, ".glb") != 0)) return 0;
    const struct rnd_scene_options options = {
        .image_program = files_image_program(), .path = path, .env_path = files_path("env.exr")};
    char error[RND_ERROR_SIZE] = "";
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) {
        print_message("%s\n", error);
        assert_non_null(strstr(error, strrchr(path, '/') + 1));
        assert_null(strchr(error, '\n'));
        refused++;
        return 0;
    }
    const struct rnd_aim aim = files_aim(0, 0, -1);
    files_radiance(scene, "od", 0, 20000, &aim, 180, NULL); /* finite all over */
    rnd_scene_destroy(scene);
    loaded++;
    return 0;
}

static void blender_tests(void **state)
{
    (void)state;
    if (access(SHARED_DATA "/scenes/gltf-tests", R_OK) != 0) {
        print_message("skipped: no " SHARED_DATA "/scenes/gltf-tests\n");
        skip();
    }
    files_env("env.exr", 1);
    assert_int_equal(nftw(SHARED_DATA "/scenes/gltf-tests", try_file, 8, FTW_PHYS), 0);
    print_message("%d loaded, %d refused\n", loaded, refused);
    assert_true(loaded > 20);
    assert_true(refused >= 1); /* 00_no_nodes */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(not_there),         cmocka_unit_test(broken),
        cmocka_unit_test(parts_absent),      cmocka_unit_test(images_absent),
        cmocka_unit_test(not_finite),        cmocka_unit_test(hostile),
        cmocka_unit_test(emissive_strength), cmocka_unit_test(transforms),
        cmocka_unit_test(camera_and_bounds), cmocka_unit_test(textures),
        cmocka_unit_test(unsupported),       cmocka_unit_test(units),
        cmocka_unit_test(blender_tests),
    };
    return cmocka_run_group_tests_name("renderer_import", tests, files_setup, files_teardown);
}
