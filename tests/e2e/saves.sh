#!/bin/sh
# What fovead saves: planes, and the same files with any threads.
. "$(dirname "$0")/common.sh"
make_room
make_log
mean() { "$programs/e2e_mean" "$@" || fail "cannot be read: $*"; }
larger() { awk "BEGIN {exit !($1 > $2)}"; }

for threads in 1 3; do
    "$fovead" --scene room.obj --size 256x128 --gaze replay:short.gaze --clock virtual --until 0.2s --threads $threads \
        --planes all --save $threads-all.exr >/dev/null
done
cmp 1-all.exr 3-all.exr || fail 'other threads, another file'
"$fovead" --scene room.obj --size 256x128 --gaze replay:short.gaze --clock virtual --until 0.2s --save none.exr >/dev/null
for channel in R G B samples error; do
    [ "$(mean none.exr $channel)" = "$(mean 1-all.exr $channel)" ] || fail "planes change $channel"
done
"$fovead" --scene room.obj --size 256x128 --until 16spp --planes position,albedo --save some.exr >/dev/null 2>&1
[ "$(mean some.exr coverage)" = 1 ] || fail "coverage in a closed room is $(mean some.exr coverage)"
larger "$(mean some.exr albedo.R)" 0.5 && larger 0.5 "$(mean some.exr albedo.G)" || fail "albedo is not that of walls of 0.6 and some of 0.7,0.1,0.1"
refused 'has no channel "normal.X"' "$programs/e2e_mean" some.exr normal.X
refused "there is no 'depth', expected all or some of albedo,normal,position,coverage,instance" "$fovead" --scene room.obj --planes depth
