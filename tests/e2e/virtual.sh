#!/bin/sh
# Under the virtual clock, the same scene, log and seed give the same file, byte for byte, with any number of threads.
. "$(dirname "$0")/common.sh"
make_room
head -n 62 "$source/fixtures/hall.gaze" >short.gaze # half a second
for mode in fv vp od; do
    if [ $mode = fv ]; then until='' samples=60; else until='--until 0.25s' samples=30; fi # all of the log, or a part
    for threads in 1 2 4; do
        "$fovead" --scene room.obj --size 512x256 --mode "$mode" --gaze replay:short.gaze --clock virtual \
            $until --threads "$threads" --seed 5 --save "$mode-$threads.exr" --json >"$mode-$threads.json" 2>/dev/null
    done
    cmp "$mode-1.exr" "$mode-2.exr"
    cmp "$mode-1.exr" "$mode-4.exr"
    # 60 samples are half a second. Rendered in that time: 100 batches of 4096 paths, after the outline with one path
    # per square of 16 x 16 pixels.
    paths=$(number paths "$mode-4.json")
    least=$((samples * 5 / 3 - 1))
    [ "$paths" -ge $((least * 4096)) ] && [ "$paths" -le $(((least + 2) * 4096)) ] || fail "$mode: $paths paths"
    [ "$(number gaze_samples "$mode-4.json")" = $samples ] || fail "not every sample was read: $(cat "$mode-4.json")"
done
# Files are compared in a way that would show a difference.
"$fovead" --scene room.obj --size 512x256 --mode fv --gaze replay:short.gaze --clock virtual --seed 6 \
    --save other.exr >/dev/null
if cmp -s fv-1.exr other.exr; then fail "another seed gives the same file"; fi
if cmp -s fv-1.exr od-1.exr; then fail "another mode gives the same file"; fi
