#!/bin/sh
# What a client shows is exactly what the daemon has: where no more paths fall, its half floats are those of the saved
# film, bit for bit.
. "$(dirname "$0")/common.sh"
make_room
start --scene room.obj --size 512x256 --gaze pointer --mode fv

# The gaze rests ahead until every pixel there has found light, and then goes where it brings no more paths there. A new
# client gets the tiles ahead as they are then.
paths=0
has_paths() { told stats.json paths "$paths"; }
wait_for_paths() {
    told stats.json paths 0
    paths=$(($(number paths stats.json) + $1))
    await "$paths paths" has_paths
}
look_ahead_and_away() {
    "$foveactl" look 0,0
    wait_for_paths 2000000
    "$foveactl" look 180,0
    wait_for_paths 300000
}
is_exact() {
    kill -0 "$daemon" || fail 'the daemon has gone'
    "$foveactl" snapshot shown.exr >/dev/null && "$foveactl" save saved.exr >/dev/null || fail 'no pictures'
    status=0
    "$programs/e2e_exact" shown.exr saved.exr >exact.txt || status=$?
    case $status in
    0) return 0 ;;
    1) ;; # a batch, or a tile, was still under way
    3) look_ahead_and_away ;; # some pixel has no light yet
    *) fail 'the pictures cannot be compared' ;;
    esac
    return 1
}
look_ahead_and_away
await 'a picture that is exact' is_exact
cat exact.txt
stop
