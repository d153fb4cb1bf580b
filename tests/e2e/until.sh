#!/bin/sh
# Renders that end by themselves: when they end, and what they write.
. "$(dirname "$0")/common.sh"
make_room
make_log

"$fovead" --scene room.obj --size 256x128 --until 3spp --save paths.exr --json >paths.json 2>paths.err
[ "$(number paths paths.json)" = $((3 * 256 * 128)) ] || fail "not 3 paths per pixel: $(cat paths.json)"
grep -q '"mode": "od"' paths.json && grep -q '"gaze": "none"' paths.json || fail "$(cat paths.json)"
[ "$(number not_finite paths.json)" = 0 ] || fail "$(cat paths.json)"
"$programs/e2e_picture" paths.exr 256 128 >/dev/null
[ ! -e fovead.sock ] || fail "a socket was opened"

"$fovead" --scene room.obj --size 256x128 --until 0.5s >seconds.txt
grep -q '^time  *0\.[5-9]' seconds.txt || grep -q '^time  *[1-9]' seconds.txt || fail "$(cat seconds.txt)"

# In a closed room that only emits, all radiance is the same, so it converges as soon as it is judged.
sed 's/Kd 0.6 0.6 0.6/Kd 0 0 0\nKe 1 1 1/; s/Kd 0.7 0.1 0.1/Kd 0 0 0\nKe 1 1 1/; s/Ke 12 12 12/Ke 1 1 1/' room.mtl >emitter.mtl
sed 's/room.mtl/emitter.mtl/' room.obj >emitter.obj
"$fovead" --scene emitter.obj --size 128x64 --until converged --json >converged.json 2>/dev/null ||
    fail "an emitter does not converge"
[ "$(number tiles_converged converged.json)" = 2 ] || fail "$(cat converged.json)"

"$fovead" --scene room.obj --size 256x128 --gaze replay:short.gaze --until end --json >end.json 2>/dev/null ||
    fail "it does not end with the recording"
[ "$(number gaze_samples end.json)" = 120 ] || fail "$(cat end.json)"
grep -q '"mode": "fv"' end.json || fail "$(cat end.json)"
"$fovead" --scene room.obj --size 128x64 --gaze replay:short.gaze --speed 0 --until end --json >fast.json 2>/dev/null
[ "$(number gaze_samples fast.json)" = 120 ] || fail "$(cat fast.json)"

"$fovead" --help | grep -q -e '--clock real|virtual' || fail "no help"
"$fovead" --version | grep -q '^fovead [0-9]' || fail "no version"
"$foveactl" --help | grep -q snapshot || fail "no help"
"$foveactl" --version | grep -q '^foveactl [0-9]' || fail "no version"

# Without a device, auto replays the recording that comes with fovead. An installed fovead takes the one that is
# installed beside it.
mkdir -p bin share/fovead
cp "$fovead" "$programs/fovead-reader" "$programs/fovead-image" bin
cp short.gaze share/fovead/hall.gaze
bin/fovead --scene room.obj --size 128x64 --gaze auto --until end --speed 0 --json >auto.json 2>/dev/null
grep -q 'share/fovead/hall.gaze' auto.json && [ "$(number gaze_samples auto.json)" = 120 ] || fail "$(cat auto.json)"
rm share/fovead/hall.gaze
bin/fovead --scene room.obj --size 128x64 --gaze auto --until end --speed 0 --json >auto.json 2>/dev/null
grep -qF "$source/fixtures/hall.gaze" auto.json || fail "$(cat auto.json)"
