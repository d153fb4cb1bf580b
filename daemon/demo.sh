#!/bin/sh
# The main job, start to end: installs what is missing, builds, renders the scene that comes with fovead where a
# recorded gaze looks, streams it to a client for the 20 seconds of the recording, and leaves pictures in out/.
set -eu
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$*"; }

daemon=
place=$(mktemp -d)
finish() {
    [ -z "$daemon" ] || kill "$daemon" 2>/dev/null || true
    rm -rf "$place"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

say "what it is built from"
sh daemon/setup.sh
say "building"
cmake -S . -B build/demo -G Ninja -DBUILD_TESTING=OFF >"$place/cmake.log" || { cat "$place/cmake.log"; exit 1; }
cmake --build build/demo --target fovead foveactl

mkdir -p out
fovead=build/demo/fovead
foveactl="build/demo/foveactl --connect unix:$place/socket"

say "the daemon"
rm -f out/preview.png out/panorama.png out/panorama.exr out/samples.png out/summary.json
"$fovead" --scene fixtures/hall.gltf --env fixtures/sky.hdr --gaze replay:fixtures/hall.gaze \
    --listen "unix:$place/socket" --json >"$place/summary.json" &
daemon=$!
until [ -S "$place/socket" ]; do
    kill -0 "$daemon" 2>/dev/null || exit 1
    sleep 0.1
done

say "20 seconds of gaze"
$foveactl watch --until-finished
say "pictures"
$foveactl snapshot out/preview.png --view gaze,90
$foveactl snapshot out/panorama.png
$foveactl save out/panorama.exr
build/demo/foveactl samples out/panorama.exr out/samples.png --gaze fixtures/hall.gaze
kill "$daemon"
wait "$daemon"
daemon=
mv "$place/summary.json" out/summary.json

say "done: open"
cat <<END
  out/preview.png     what the viewer saw at the last gaze, 90 degrees wide
  out/panorama.png    the whole sphere; out/panorama.exr the same for 360-degree viewers, with sample counts
  out/samples.png     where samples went, and the path of the gaze
  out/summary.json    figures

Your own scene and recorded gaze:
  build/demo/fovead --scene SCENE.gltf --env SKY.hdr --gaze replay:LOG
and in another terminal
  build/demo/foveactl watch
  build/demo/foveactl snapshot view.png --view gaze,90
More: build/demo/fovead --help, build/demo/foveactl --help

To look around in the hall with a browser, your pointer being the gaze, run
  build/demo/fovead --scene fixtures/hall.gltf --env fixtures/sky.hdr --gaze pointer --listen http:127.0.0.1:7462
and open
  http://127.0.0.1:7462/
END
