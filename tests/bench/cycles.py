"""fovead beside Blender Cycles: the same scene, light and camera. cycles.sh starts it inside Blender.

First the scene is rewritten to what both can show: triangles with normals and texture coordinates, and diffuse materials
with base colour, texture and emission. Both read that file. Then each renders the panorama twice, and the gaze disc alone
twice, from different random numbers. Their means are compared, weighted by solid angle. The differences between the two
renders of a pixel tell the standard error of the means. Finally both race in turns, so that a machine that slows down
slows both.
"""
import argparse
import json
import math
import operator
import os
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cycles_scene  # noqa: E402

DISC_DEG = 5.79
BAR = 0.01  # means agree if their difference plus twice its standard error is below
REGION_DEG = 100
LUMINANCE = (0.2126, 0.7152, 0.0722)


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise cycles_scene.Unreadable(message)


def numbers(count):
    def parse(text):
        values = tuple(float(part) for part in text.split(","))
        if len(values) != count or not all(map(math.isfinite, values)):
            raise ValueError
        return values
    parse.__name__ = "list of %d numbers" % count
    return parse


def at_least(least):
    def parse(text):
        value = int(text)
        if value < least:
            raise ValueError
        return value
    parse.__name__ = "number of %d or more" % least
    return parse


def parse(arguments):
    parser = Parser(prog="cycles.sh", description=(
        "Mean radiance and paths per second of fovead and of Blender Cycles: same scene, light and camera, diffuse "
        "materials."))
    add = parser.add_argument
    add("--fovead", default="build/release/fovead", metavar="PROGRAM", help="default: build/release/fovead")
    add("--scene", metavar="FILE.gltf", help="default: the shipped hall, with its sky")
    add("--env", metavar="FILE", help="environment map")
    add("--sun", type=numbers(4), metavar="A,E,I,D", help="azimuth, elevation, irradiance, angular diameter (deg)")
    add("--camera", "--eye", dest="camera", type=numbers(3), metavar="X,Y,Z", help="m; default: the file's first camera")
    add("--gaze", type=numbers(2), default=(30.0, -10.0), metavar="A,E", help="azimuth (right) and elevation, deg; 30,-10")
    add("--bounces", type=at_least(1), default=4, metavar="N", help="fovead's: surfaces after the first; 4")
    add("--flat", action="store_true", help="leave out the vertices' normals: where they make a face look curved, Cycles "
        "bends them towards the camera and darkens what it bent")
    add("--threads", type=at_least(1), default=2, metavar="N", help="of both; 2")
    add("--width", type=at_least(128), default=512, metavar="N", help="of the panoramas compared; a multiple of 128; 512")
    add("--paths", type=float, default=4.0, metavar="N", help="millions, of each render that is compared; 4")
    add("--turns", type=int, default=3, metavar="N", help="of the race, medians are printed; 0: no race; 3")
    add("--seconds", type=float, default=5.0, metavar="S", help="of a turn of each; 5")
    add("--race-width", type=at_least(128), default=1024, metavar="N", help="of the film in the race; 1024")
    add("--keep", metavar="DIR", help="keep the panoramas compared there, as EXR")
    add("--json", action="store_true", help="one JSON object instead of the tables")
    return parser.parse_args(arguments)


# --- the scene that both read ---


def link(directory, folder, uri, name):
    """Link a file under a plain name beside the rewritten scene, because readers differ in which paths they accept."""
    if uri.startswith("data:"):
        return uri
    os.symlink(os.path.join(folder, uri), os.path.join(directory, name))
    return name


def diffuse(material):
    base = material.get("pbrMetallicRoughness", {})
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    out = {
        "pbrMetallicRoughness": {"baseColorFactor": [*base.get("baseColorFactor", (1, 1, 1))[:3], 1],
                                 "metallicFactor": 0, "roughnessFactor": 1},
        "emissiveFactor": material.get("emissiveFactor", [0, 0, 0]),
        "doubleSided": material.get("doubleSided", False),
        "extensions": {"KHR_materials_specular": {"specularFactor": 0},
                       "KHR_materials_emissive_strength": {"emissiveStrength": strength}},
    }
    if "baseColorTexture" in base:
        out["pbrMetallicRoughness"]["baseColorTexture"] = {"index": base["baseColorTexture"]["index"]}
    if "emissiveTexture" in material:
        out["emissiveTexture"] = {"index": material["emissiveTexture"]["index"]}
    return out


def rewrite(path, directory, flat):
    """Write the scene into directory with only what both can show. Returns the scene and its path."""
    kept = ("POSITION", "TEXCOORD_0") if flat else ("POSITION", "NORMAL", "TEXCOORD_0")
    try:
        with open(path, "rb") as file:
            gltf = json.loads(file.read())
        folder = os.path.dirname(os.path.abspath(path))
        for i, buffer in enumerate(gltf["buffers"]):
            buffer["uri"] = link(directory, folder, buffer["uri"], "buffer%d.bin" % i)
        for i, image in enumerate(gltf.get("images", ())):
            image["uri"] = link(directory, folder, image["uri"], "image%d%s" % (i, os.path.splitext(image["uri"])[1]))
        gltf["materials"] = [dict(diffuse(m), name="material %d" % i)
                             for i, m in enumerate(gltf.get("materials", []) + [{}])]
        for mesh in gltf["meshes"]:
            for primitive in mesh["primitives"]:
                if primitive.get("mode", 4) != 4:
                    raise cycles_scene.Unreadable("%s: holds more than triangles" % path)
                primitive.setdefault("material", len(gltf["materials"]) - 1)
                attributes = primitive["attributes"]
                primitive["attributes"] = {k: attributes[k] for k in kept if k in attributes}
    except (ValueError, KeyError, TypeError, AttributeError):
        raise cycles_scene.Unreadable("%s: not readable as glTF JSON with separate files" % path) from None
    except OSError as error:
        raise cycles_scene.Unreadable("%s: %s" % (path, error.strerror)) from None
    for unused in ("animations", "skins", "extensionsRequired", "extensions"):
        gltf.pop(unused, None)
    gltf["extensionsUsed"] = ["KHR_materials_specular", "KHR_materials_emissive_strength"]
    for node in gltf["nodes"]:
        node.pop("extensions", None)
        node.pop("skin", None)
    out = os.path.join(directory, "scene.gltf")
    with open(out, "w") as file:
        json.dump(gltf, file)
    return gltf, out


def first_camera(gltf, path):
    for node, world in cycles_scene.walk(gltf):
        if "camera" in node:
            return tuple(world.to_translation())
    raise cycles_scene.Unreadable("%s: has no camera: --camera is needed" % path)


# --- fovead ---


def fovead(setup, *options):
    """Run fovead. Returns its summary."""
    command = [setup.fovead, "--scene", setup.rewritten, "--camera", "%.9g,%.9g,%.9g" % setup.camera, "--bounces",
               str(setup.bounces), "--threads", str(setup.threads), "--json", *options]
    if setup.env:
        command += ["--env", setup.env]
    if setup.sun:
        command += ["--sun", "%.9g,%.9g,%.9g,%.9g" % setup.sun]
    try:
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    except OSError as error:
        raise cycles_scene.Unreadable("%s: %s" % (setup.fovead, error.strerror)) from None
    if run.returncode:
        raise cycles_scene.Unreadable("%s failed: %s" % (setup.fovead, run.stderr.strip().split("\n")[-1]))
    return json.loads(run.stdout)


def still_gaze(setup, path):
    """Write a log in which head and eye rest, in fovead's own format: one second at 120 Hz, to be replayed in a loop."""
    with open(os.path.join(setup.fixtures, "hall.gaze")) as file:
        first = file.readline() + file.readline()
    columns = len(first.split("\n")[1].split(" "))
    yaw, pitch = -0.5 * math.radians(setup.gaze[0]), 0.5 * math.radians(setup.gaze[1])
    head = (math.cos(yaw) * math.sin(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(yaw) * math.sin(pitch),
            math.cos(yaw) * math.cos(pitch))
    with open(path, "w") as file:
        file.write(first)
        for i in range(120):
            row = [i + 1, i * 8333333, i * 8333333, 1 + 4, 0, 0, -1, *[0] * (columns - 11), *("%.8f" % q for q in head)]
            file.write(" ".join(map(str, row)) + "\n")
    return path


# --- means ---


def weights(width, height, setup):
    """The weight of each row by solid angle, the pixels whose middle is in the gaze disc, and all pixels. Pixels that the
    sun's disc may touch are left out, because Cycles does not show it to a camera.
    """
    def toward(azimuth, elevation):
        azimuth, elevation = math.radians(azimuth), math.radians(elevation)
        return math.cos(elevation) * math.sin(azimuth), math.sin(elevation), -math.cos(elevation) * math.cos(azimuth)

    gaze, near = toward(*setup.gaze), math.cos(math.radians(DISC_DEG))
    sun = toward(*setup.sun[:2]) if setup.sun else None
    dazzled = math.cos(math.radians(setup.sun[3] / 2 + 360 / width)) if sun else None
    rows, disc, every = [], [], []
    for y in range(height):
        elevation = ((y + 0.5) / height - 0.5) * 180  # rows count from the bottom
        rows.append(math.cos(math.radians(elevation)))
        for x in range(width):
            d = toward(((x + 0.5) / width - 0.5) * 360, elevation)
            if sun and sum(map(operator.mul, d, sun)) >= dazzled:
                continue
            every.append(y * width + x)
            if sum(map(operator.mul, d, gaze)) >= near:
                disc.append(y * width + x)
    return rows, disc, every


def mean(pair, width, rows, places):
    """Mean R, G, B of some pixels in two renders of a panorama, the mean luminance, and its standard error.

    If the renders a and b of a pixel are independent, the expected variance of their mean is (a - b)^2 / 4.
    """
    total, rgb, square = 0.0, [0.0, 0.0, 0.0], 0.0
    a, b = pair
    for i in places:
        weight = rows[i // width]
        total += weight
        difference = 0.0
        for c in range(3):
            rgb[c] += 0.5 * weight * (a[4 * i + c] + b[4 * i + c])
            difference += LUMINANCE[c] * (a[4 * i + c] - b[4 * i + c])
        square += (0.5 * weight * difference) ** 2
    rgb = [value / total for value in rgb]
    return {"rgb": rgb, "luminance": sum(map(operator.mul, LUMINANCE, rgb)), "error": math.sqrt(square) / total}


def region(setup, width, degrees):
    """The part of a panorama that covers this many degrees around the gaze: left, right, bottom and top, in pixels."""
    per, height = width / 360, width // 2
    x, y = (180 + setup.gaze[0]) * per, (90 + setup.gaze[1]) * per
    half_y = degrees / 2 * per
    half_x = half_y / max(math.cos(math.radians(abs(setup.gaze[1]))), 0.01) if degrees < 90 else half_y
    left, right = math.floor(x - half_x), math.ceil(x + half_x)
    if left < 0 or right > width:  # it crosses the seam
        left, right = 0, width
    return left, right, max(math.floor(y - half_y), 0), min(math.ceil(y + half_y), height)


def verdict(difference, error):
    if abs(difference) + 2 * error <= BAR:
        return "yes"
    return "no" if abs(difference) - 2 * error > BAR else "unsure"


def compare_part(setup, name, places, rows, part, how, directory):
    """A row of the first table: the mean of some pixels, from renders of a part of the panorama (None: all of it)."""
    pixels = setup.width * (setup.width // 2)
    inside = (part[1] - part[0]) * (part[3] - part[2]) if part else pixels
    pairs = {"fovead": [], "cycles": []}
    for seed in (1, 2):
        path = os.path.join(directory, "%s-fovead-%d.exr" % (name, seed))
        say("%s by fovead, %d of 2" % (name, seed))
        until = "%dspp" % max(1, round(setup.paths * 1e6 / pixels))
        fovead(setup, *how, "--size", str(setup.width), "--until", until, "--seed", str(seed), "--save", path)
        pairs["fovead"].append(cycles_scene.pixels(path))
        path = os.path.join(directory, "%s-cycles-%d.exr" % (name, seed))
        say("%s by Cycles, %d of 2" % (name, seed))
        cycles_scene.render(setup.width, max(1, round(setup.paths * 1e6 / inside)), seed, path, part)
        pairs["cycles"].append(cycles_scene.pixels(path))
    ours, theirs = (mean(pairs[who], setup.width, rows, places) for who in ("fovead", "cycles"))
    whole = theirs["luminance"] or math.nan
    difference = ours["luminance"] / whole - 1
    error = math.hypot(ours["error"], theirs["error"]) / whole
    return {"what": name, "fovead": ours, "cycles": theirs, "difference": difference, "error": error,
            "agrees": verdict(difference, error),
            "rgb_difference": [a / b - 1 if b else math.nan for a, b in zip(ours["rgb"], theirs["rgb"])]}


def compare(setup, directory):
    """The rows of the first table."""
    places = setup.keep or directory
    rows, disc, every = weights(setup.width, setup.width // 2, setup)
    viewport = "%.9g" % (2 * DISC_DEG + 2)
    gaze = ["--mode", "vp", "--fov", viewport + "," + viewport, "--gaze", "replay:" + setup.still, "--loop"]
    around = region(setup, setup.width, 2 * DISC_DEG + 1)
    return [compare_part(setup, "disc", disc, rows, around, gaze, places),
            compare_part(setup, "panorama", every, rows, None, ["--mode", "od"], places)]


# --- speed ---


def cycles_speed(setup, path, part, spp):
    """Paths per second, from the difference between a long render and one of one path per pixel, which has the same start."""
    few, few_seconds = cycles_scene.render(setup.race_width, 1, 1, path, part)
    paths, seconds = cycles_scene.render(setup.race_width, 1 + spp, 2, path, part)
    return (paths - few) / max(seconds - few_seconds, 1e-3)


def fill_turn(setup, path, part):
    """How many paths per pixel Cycles needs to fill a turn: doubled until the time that they take can be measured."""
    spp, seconds = 1, 0.0
    while seconds < 0.4 * setup.seconds:
        spp *= 2
        seconds = cycles_scene.render(setup.race_width, spp, 1, path, part)[1]
    return max(1, round(spp * setup.seconds / seconds))


def race(setup, directory):
    """The rows of the second table: medians of paths per second."""
    path = os.path.join(directory, "race.exr")
    until = ["--size", str(setup.race_width), "--until", "%gs" % setup.seconds]
    ways = {
        "cycles panorama": None, "cycles region": region(setup, setup.race_width, REGION_DEG),
        "fovead od": ["--mode", "od", *until],
        "fovead fv": ["--mode", "fv", "--gaze", "replay:" + setup.still, "--loop", *until],
    }
    spp = {}
    for name in ("cycles panorama", "cycles region"):
        say("%s, warming up" % name)
        spp[name] = fill_turn(setup, path, ways[name])
    speeds = {name: [] for name in ways}
    for turn in range(setup.turns):
        for name, how in ways.items():
            say("%s, turn %d of %d" % (name, turn + 1, setup.turns))
            if name in spp:
                speeds[name].append(cycles_speed(setup, path, how, spp[name]))
            else:
                speeds[name].append(fovead(setup, *how)["paths_per_second"])
    return [{"what": name, "paths_per_second": statistics.median(values), "turns": values}
            for name, values in speeds.items()]


# --- output ---


def say(text):
    print("cycles: " + text, file=sys.stderr, flush=True)


def table(setup, triangles, means, speeds):
    lines = ["%s, %d triangles, made diffuse%s; camera %g,%g,%g; gaze %g right, %g up" %
             (setup.scene, triangles, " and flat" if setup.flat else "", *setup.camera, *setup.gaze),
             "fovead --bounces %d, Cycles %d bounces: %d surfaces a path at most" %
             (setup.bounces, setup.bounces - 1, setup.bounces + 1),
             "mean radiance (luminance), panorama of %d x %d, two renders each of %g million paths%s" %
             (setup.width, setup.width // 2, setup.paths, "; without the sun's own disc" if setup.sun else ""),
             "%-16s %23s %23s %18s   %-24s %s" % ("", "fovead", "Cycles", "difference", "of R, G, B", "within 1 %")]
    for row in means:
        ours, theirs = row["fovead"], row["cycles"]
        lines.append("%-16s %11.5g +- %-8.2g %11.5g +- %-8.2g %+7.2f +- %.2f %%   %-24s %s" % (
            "gaze disc" if row["what"] == "disc" else row["what"], ours["luminance"], ours["error"],
            theirs["luminance"], theirs["error"], 100 * row["difference"], 100 * row["error"],
            "%+.2f %+.2f %+.2f %%" % tuple(100 * d for d in row["rgb_difference"]), row["agrees"]))
    if speeds:
        first = speeds[0]["paths_per_second"]
        lines.append("paths per second, film %d x %d, %d threads each, medians of %d turns of %g s" %
                     (setup.race_width, setup.race_width // 2, setup.threads, setup.turns, setup.seconds))
        for row in speeds:
            lines.append("%-16s %7.3f M   %5.2f x Cycles' panorama" % (
                row["what"], row["paths_per_second"] * 1e-6, row["paths_per_second"] / first))
    return "\n".join(lines)


def measure(arguments, directory, out):
    setup = parse(arguments)
    setup.fixtures = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "fixtures")
    if not setup.scene:
        setup.scene = os.path.join(setup.fixtures, "hall.gltf")
        setup.env = setup.env or os.path.join(setup.fixtures, "sky.hdr")
    if setup.env and not os.path.isfile(setup.env):
        raise cycles_scene.Unreadable("%s: no such file" % setup.env)
    if abs(setup.gaze[0]) > 180 or abs(setup.gaze[1]) > 90:
        raise cycles_scene.Unreadable("argument --gaze: expected -180 to 180 and -90 to 90 degrees")
    setup.env = setup.env and os.path.abspath(setup.env)
    setup.keep = setup.keep and os.path.abspath(setup.keep)
    if setup.keep:
        os.makedirs(setup.keep, exist_ok=True)
    gltf, setup.rewritten = rewrite(setup.scene, directory, setup.flat)
    setup.camera = setup.camera or first_camera(gltf, setup.scene)
    say("reading %s into Blender" % setup.scene)
    triangles = cycles_scene.build(gltf, directory, setup)
    setup.still = still_gaze(setup, os.path.join(directory, "still.gaze"))
    means = compare(setup, directory)
    speeds = race(setup, directory) if setup.turns > 0 else []
    if setup.json:
        json.dump({"scene": setup.scene, "triangles": triangles, "flat": setup.flat, "camera": setup.camera, "gaze": setup.gaze,
                   "bounces": setup.bounces, "threads": setup.threads, "width": setup.width, "paths": setup.paths,
                   "means": means, "speeds": speeds}, out, indent=1)
        out.write("\n")
    else:
        out.write(table(setup, triangles, means, speeds) + "\n")
    return not any(row["agrees"] == "no" for row in means)


def main():
    directory, *arguments = sys.argv[sys.argv.index("--") + 1:]
    with os.fdopen(3, "w") as out:  # Blender prints to standard output
        try:
            good = measure(arguments, directory, out)
        except cycles_scene.Unreadable as error:
            say(str(error))
            out.flush()
            os._exit(2)  # without Blender's own message
        except Exception as error:  # Blender would print a trace to standard output
            say("%s: %s" % (type(error).__name__, error))
            os._exit(1)
    sys.exit(0 if good else 1)


main()
