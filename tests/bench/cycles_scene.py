"""A glTF scene of diffuse materials in Blender Cycles, as fovead sees it: run by cycles.py.

Blender's own importer is not used: it needs numpy, which Debian's Blender may lack, and it changes materials as Blender
thinks best. Frame: glTF's -Z, which is forward, becomes +X here, +X becomes -Y, and +Y becomes +Z. Forward is then in the
middle of Cycles' equirectangular images, both of the environment and of the camera.
"""
import array
import base64
import math
import os
import struct
import time

import bpy
from mathutils import Matrix, Vector

FRAME = Matrix(((0, 0, -1, 0), (-1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


class Unreadable(Exception):
    """Says in one line what is wrong with a scene or an option."""


def owner(thing, name):
    """The holder of a Cycles setting: the object or camera itself in newer Blenders, its `cycles` part in Blender 3.4."""
    return thing if hasattr(thing, name) else thing.cycles


# --- geometry ---


def local_matrix(node):
    if "matrix" in node:
        m = node["matrix"]
        return Matrix([[m[4 * column + row] for column in range(4)] for row in range(4)])
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    sx, sy, sz = node.get("scale", (1, 1, 1))
    tx, ty, tz = node.get("translation", (0, 0, 0))
    return Matrix((
        ((1 - 2 * (y * y + z * z)) * sx, 2 * (x * y - z * w) * sy, 2 * (x * z + y * w) * sz, tx),
        (2 * (x * y + z * w) * sx, (1 - 2 * (x * x + z * z)) * sy, 2 * (y * z - x * w) * sz, ty),
        (2 * (x * z - y * w) * sx, 2 * (y * z + x * w) * sy, (1 - 2 * (x * x + y * y)) * sz, tz),
        (0, 0, 0, 1)))


def walk(gltf):
    """Every node of the scene with its matrix: node to world, in glTF's frame."""
    waiting = [(i, Matrix()) for i in gltf["scenes"][gltf.get("scene", 0)]["nodes"]]
    while waiting:
        index, parent = waiting.pop()
        node = gltf["nodes"][index]
        world = parent @ local_matrix(node)
        yield node, world
        waiting += [(child, world) for child in node.get("children", ())]


class Buffers:
    """The numbers behind a glTF file's accessors."""

    KIND = {5121: ("B", 1), 5123: ("H", 2), 5125: ("I", 4), 5126: ("f", 4)}
    WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}

    def __init__(self, gltf, directory):
        self.gltf, self.bytes = gltf, []
        for buffer in gltf["buffers"]:
            uri = buffer["uri"]
            if uri.startswith("data:"):
                self.bytes.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                with open(os.path.join(directory, uri), "rb") as file:
                    self.bytes.append(file.read())

    def read(self, index, kinds):
        """An accessor as a flat array. Its component type must be one of kinds."""
        accessor = self.gltf["accessors"][index]
        if accessor["componentType"] not in kinds or "sparse" in accessor or "bufferView" not in accessor:
            raise Unreadable("accessor %d has a type that this program does not read" % index)
        code, size = self.KIND[accessor["componentType"]]
        width = self.WIDTH[accessor["type"]]
        view = self.gltf["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", width * size)
        data = self.bytes[view["buffer"]]
        out = array.array(code)
        if stride == width * size:
            out.frombytes(data[start:start + accessor["count"] * stride])
        else:
            for i in range(accessor["count"]):
                out.extend(struct.unpack_from("<%d%s" % (width, code), data, start + i * stride))
        return out


def split(faces, *attributes):
    """Split every triangle into four, again and again while there are at most 1024. Returns the faces; the arrays of the
    attributes grow.

    This is for emitters. If a triangle is longer than it is far away, Cycles 3.4 draws from its solid angle, and its fast
    arc cosines cause errors of about 1e-4: measured, an emitter of 1 m^2 at 3 m is 4 % too dark at grazing angles.
    """
    while 0 < 4 * len(faces) <= 1024:
        finer = []
        for face in faces:
            first = len(attributes[0][0]) // attributes[0][1]
            for values, width in attributes:
                for k in range(3):
                    i, j = width * face[k], width * face[(k + 1) % 3]
                    values.extend([0.5 * (values[i + c] + values[j + c]) for c in range(width)])
            finer += [(face[0], first, first + 2), (first, face[1], first + 1), (first + 2, first + 1, face[2]),
                      (first, first + 1, first + 2)]
        faces = finer
    return faces


def add_mesh(buffers, primitive, world, material, emits):
    """Add a primitive with its vertices in the world frame: a node's matrix may shear, a Blender object's cannot."""
    attributes = primitive["attributes"]
    position = buffers.read(attributes["POSITION"], (5126,))
    normal = buffers.read(attributes["NORMAL"], (5126,)) if "NORMAL" in attributes else None
    uv = buffers.read(attributes["TEXCOORD_0"], (5126,)) if "TEXCOORD_0" in attributes else None
    index = (buffers.read(primitive["indices"], (5121, 5123, 5125)) if "indices" in primitive
             else range(len(position) // 3))
    turned = world.determinant() < 0
    faces = [(index[i], index[i + 2], index[i + 1]) if turned else (index[i], index[i + 1], index[i + 2])
             for i in range(0, len(index) - 2, 3)]
    triangles = len(faces)
    faces = [f for f in faces if f[0] != f[1] and f[1] != f[2] and f[2] != f[0]]
    if emits:
        faces = split(faces, *((values, width) for values, width in ((position, 3), (normal, 3), (uv, 2)) if values))
    to_here = FRAME @ world
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([position[i:i + 3] for i in range(0, len(position), 3)], [], faces)
    mesh.transform(to_here)
    mesh.materials.append(material)
    if uv:
        flat = array.array("f")
        for face in faces:
            for i in face:
                flat.extend((uv[2 * i], 1 - uv[2 * i + 1]))
        mesh.uv_layers.new().data.foreach_set("uv", flat)
    if normal:
        turn = to_here.to_3x3().inverted_safe().transposed()
        mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
        if hasattr(mesh, "use_auto_smooth"):
            mesh.use_auto_smooth = True  # before Blender 4.1, Cycles ignores normals without it
        mesh.normals_split_custom_set_from_vertices(
            [(turn @ Vector(normal[i:i + 3])).normalized() for i in range(0, len(normal), 3)])
    thing = bpy.data.objects.new("object", mesh)
    owner(thing, "shadow_terminator_geometry_offset").shadow_terminator_geometry_offset = 0  # biased, and on by default
    bpy.context.scene.collection.objects.link(thing)
    return triangles


# --- materials ---


def decoded(path):
    """A texture as linear floats. Cycles filters byte textures before it decodes them, which makes them a little darker."""
    name = "linear " + path
    if name in bpy.data.images:
        return bpy.data.images[name]
    image = bpy.data.images.load(path)
    width, height = image.size
    if not width:
        raise Unreadable("%s: not a readable image" % path)
    if image.is_float:
        return image
    values = array.array("f", bytes(16 * width * height))
    image.pixels.foreach_get(values)
    step = array.array("f", [1 / 255])[0]
    code = array.array("f", [i * step for i in range(256)])  # as Blender computes them
    linear = {v: v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in code}
    out = bpy.data.images.new(name, width, height, float_buffer=True)
    out.colorspace_settings.name = "Non-Color"
    out.pixels.foreach_set(array.array("f", map(linear.__getitem__, values)))
    out.pack()
    bpy.data.images.remove(image)
    return out


def add_image(nodes, gltf, directory, texture):
    """Add a node with the image of a glTF texture, filtered linearly and repeated."""
    image = gltf["images"][gltf["textures"][texture]["source"]]
    node = nodes.new("ShaderNodeTexImage")
    node.image = decoded(os.path.join(directory, image["uri"]))
    node.interpolation, node.extension = "Linear", "REPEAT"
    return node.outputs["Color"]


def add_product(tree, gltf, directory, factor, texture):
    """The output of a node that multiplies factor and texture; None without a texture."""
    if texture is None:
        return None
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "MULTIPLY"
    node.inputs[0].default_value = factor
    tree.links.new(add_image(tree.nodes, gltf, directory, texture), node.inputs[1])
    return node.outputs[0]


def set_colour(tree, node, gltf, directory, factor, texture):
    output = add_product(tree, gltf, directory, factor, texture)
    if output:
        tree.links.new(output, node.inputs["Color"])
    else:
        node.inputs["Color"].default_value = (*factor, 1)


def make_material(gltf, directory, description):
    """Lambert with the base colour, and emission, which is only from the front unless the material is double-sided."""
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    base = description["pbrMetallicRoughness"]
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Roughness"].default_value = 0
    set_colour(tree, diffuse, gltf, directory, base["baseColorFactor"][:3], base.get("baseColorTexture", {}).get("index"))
    if not any(description["emissiveFactor"]):
        tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
        return material
    emission = tree.nodes.new("ShaderNodeEmission")
    strength = description["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    emission.inputs["Strength"].default_value = strength
    set_colour(tree, emission, gltf, directory, description["emissiveFactor"],
               description.get("emissiveTexture", {}).get("index"))
    if not description["doubleSided"]:
        geometry = tree.nodes.new("ShaderNodeNewGeometry")
        front = tree.nodes.new("ShaderNodeMath")
        front.operation = "MULTIPLY_ADD"  # 0 on the back, the strength on the front
        front.inputs[1].default_value, front.inputs[2].default_value = -strength, strength
        tree.links.new(geometry.outputs["Backfacing"], front.inputs[0])
        tree.links.new(front.outputs[0], emission.inputs["Strength"])
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(diffuse.outputs[0], both.inputs[0])
    tree.links.new(emission.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    return material


# --- light and camera ---


def add_env(path):
    world = bpy.context.scene.world
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    tree.links.new(background.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    if path:
        node = tree.nodes.new("ShaderNodeTexEnvironment")
        node.image = bpy.data.images.load(path)
        node.projection, node.interpolation = "EQUIRECTANGULAR", "Linear"
        tree.links.new(node.outputs["Color"], background.inputs["Color"])


def add_sun(azimuth, elevation, irradiance, diameter):
    """Add a sun with the arguments of fovead --sun: degrees to the right of -Z, degrees up, irradiance, degrees."""
    light = bpy.data.lights.new("sun", "SUN")
    light.energy, light.angle = irradiance, math.radians(diameter)
    sun = bpy.data.objects.new("sun", light)
    # Without a rotation it is at the zenith. Forward is +X, right is -Y.
    sun.rotation_euler = (0, math.radians(90 - elevation), math.radians(-azimuth))
    bpy.context.scene.collection.objects.link(sun)


def add_camera(position):
    data = bpy.data.cameras.new("camera")
    data.type = "PANO"
    owner(data, "panorama_type").panorama_type = "EQUIRECTANGULAR"
    data.clip_start, data.clip_end = 1e-4, 1e9
    camera = bpy.data.objects.new("camera", data)
    camera.location = FRAME @ Vector(position)
    camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)  # looks along +X, +Z is up
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def settle(bounces, threads):
    """Set up plain unidirectional path tracing, without anything that trades noise for bias, and a filter of one pixel.

    fovead's bounces are one more than those of Cycles for the same paths.
    """
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.render.use_persistent_data = True
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_fast_gi = cycles.use_guiding = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    # The first path of a pixel goes through its middle whatever the filter is, which is a bias while paths are few.
    cycles.sample_offset = 1
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = bounces - 1


# --- both ---


def build(gltf, directory, setup):
    """Make the Blender scene of a glTF file that cycles.py has prepared. Returns the number of triangles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.world = bpy.data.worlds.new("world")
    settle(setup.bounces, setup.threads)
    buffers = Buffers(gltf, directory)
    materials = [make_material(gltf, directory, m) for m in gltf["materials"]]
    triangles = 0
    for node, world in walk(gltf):
        if "mesh" in node:
            for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
                material = primitive["material"]
                triangles += add_mesh(buffers, primitive, world, materials[material],
                                      any(gltf["materials"][material]["emissiveFactor"]))
    add_env(setup.env)
    if setup.sun:
        add_sun(*setup.sun)
    add_camera(setup.camera)
    return triangles


def render(width, spp, seed, path, part=None):
    """Render the panorama, or a part of it: left, right, bottom and top, in pixels from the lower left corner. The rest stays
    black. Returns the number of paths and the total time in seconds.
    """
    scene = bpy.context.scene
    height = width // 2
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.use_border, scene.render.use_crop_to_border = part is not None, False
    left, right, bottom, top = part or (0, width, 0, height)
    # Blender truncates these to whole pixels: 0.1 more keeps rounding from losing one.
    scene.render.border_min_x, scene.render.border_max_x = (left + 0.1) / width, (right + 0.1) / width
    scene.render.border_min_y, scene.render.border_max_y = (bottom + 0.1) / height, (top + 0.1) / height
    scene.cycles.samples, scene.cycles.seed = spp, seed
    scene.render.filepath = path
    begin = time.monotonic()
    bpy.ops.render.render(write_still=True)
    return (right - left) * (top - bottom) * spp, time.monotonic() - begin


def pixels(path):
    """The R, G, B, A floats of an EXR as they are in the file, from its lower left corner."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    out = array.array("f", bytes(4 * len(image.pixels)))
    image.pixels.foreach_get(out)
    bpy.data.images.remove(image)
    return out
