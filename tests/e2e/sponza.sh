#!/bin/sh
# A real scene with a real recording, from start to end. In tiles where samples fell, at most one pixel in 100,000 of
# the client's picture may be black or not finite. The project does not own this data, so the test is skipped where it
# is absent.
. "$(dirname "$0")/common.sh"
data=$source/../shared/data
log=$data/gaze/htc-vive-pro-eye/TESTNA01_360VR_Fist3.csv
[ -f "$log" ] || { echo "skipped: $log is not here"; exit 77; }

"$fovead" --scene "$data/scenes/dabrovic-sponza/dabrovic-sponza.gltf" --env "$data/envmaps/kiara_1_dawn_1k.hdr" \
    --sun 60,60,5,0.53 --camera 0,2,0 --gaze "replay:$log" --listen "unix:$place/fovead.sock" --json \
    >daemon.json 2>daemon.err &
daemon=$!
"$foveactl" --wait watch --until-finished >watch.txt
"$foveactl" snapshot shown.exr >/dev/null
"$foveactl" save saved.exr >/dev/null
kill "$daemon"
wait "$daemon" || fail "the daemon did not end well"
daemon=
grep -q '"not_finite": 0,' daemon.json && grep -q '"gaze_samples": 1665,' daemon.json || fail "$(cat daemon.json)"
"$programs/e2e_picture" shown.exr 4096 2048 saved.exr
