#!/bin/sh
# Under the virtual clock the same scene, log and seed give the same file, byte for byte, with any number of threads.
. "$(dirname "$0")/common.sh"
make_room
make_log
for mode in fv vp od; do
    for threads in 1 2 4; do
        "$fovead" --scene room.obj --size 512x256 --mode "$mode" --gaze replay:short.gaze --clock virtual \
            --threads "$threads" --seed 5 --save "$mode-$threads.exr" --json >"$mode-$threads.json" 2>/dev/null
    done
    cmp "$mode-1.exr" "$mode-2.exr"
    cmp "$mode-1.exr" "$mode-4.exr"
    # A second of log is 200 batches of 4096 paths, after the outline's one a square of 16 x 16.
    paths=$(number paths "$mode-4.json")
    [ "$paths" -ge $((199 * 4096)) ] && [ "$paths" -le $((201 * 4096)) ] || fail "$paths paths in a second of log"
    [ "$(number gaze_samples "$mode-4.json")" = 120 ] || fail "not every sample was read: $(cat "$mode-4.json")"
done
# And it would show if they did not.
"$fovead" --scene room.obj --size 512x256 --mode fv --gaze replay:short.gaze --clock virtual --seed 6 \
    --save other.exr >/dev/null
if cmp -s fv-1.exr other.exr; then fail "another seed gives the same file"; fi
if cmp -s fv-1.exr od-1.exr; then fail "another mode gives the same file"; fi
