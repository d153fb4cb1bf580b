#!/bin/sh
# An eye tracker is plugged in while a recording is replayed, among umockdev's fake devices: the stream tells of it, its
# recentring is kept for the next start, and its recording can be replayed.
. "$(dirname "$0")/common.sh"
if ! [ -x "$programs/device_plug" ] || ! command -v umockdev-wrapper >/dev/null; then
    echo "skipped: umockdev is not installed (sh daemon/setup.sh tests)"
    exit 77
fi
# umockdev's preload comes before a sanitizer's library, and its leaks are not ours to check.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0:detect_leaks=0"
export XDG_STATE_HOME="$place/state"
make_room

# The script that runs with the tracker, whose gaze rests 9 degrees to the right.
cat >clients.sh <<'END'
set -eu
fail() { echo "$*" >&2; exit 1; }
. "$3/tests/room.sh"
"$1" --scene room.obj --size 256x128 --gaze auto >daemon.out 2>daemon.err &
daemon=$!
trap 'kill $daemon' EXIT
"$2" --wait stats --json >before.json
touch asked
ctl=$2
is_plugged() { "$ctl" stats --json >plugged.json; grep -q '"present": true' plugged.json && grep -q '"gaze": "eye tracker' plugged.json; }
has_recorded() { "$ctl" stats --json | grep -q '"recorded": [0-9][0-9]'; }
recentred() { "$ctl" recentre 0,0 >said 2>why || ! grep -q 'not at rest' why; }
tells_of_it() { "$ctl" watch --for 0.5 --json >watch.json; grep -q '"tracker": {' watch.json; }
await 'the tracker' is_plugged
"$ctl" record tracker.gaze >/dev/null
await 'an eye at rest' recentred
await 'the tracker in the stream' tells_of_it
await 'samples' has_recorded
"$ctl" record --stop >recorded
trap - EXIT
kill $daemon
wait $daemon
END
umockdev-wrapper "$programs/device_plug" run file:asked still:25 -- sh clients.sh "$fovead" "$foveactl" "$source" >plug.out 2>plug.err ||
    fail "$(cat plug.err daemon.err ./*.json why 2>/dev/null)"
grep -q 'hall.gaze.*no eye tracker found' before.json || fail "$(cat before.json)"
grep -q '^fovead: gaze: eye tracker Fovea Test Tracker' daemon.err || fail "the daemon does not report the tracker: $(cat daemon.err)"
grep -q 'turned by [0-9.]* degrees, also after the next start' said || fail "$(cat said)"
grep -q '"tracker": {' watch.json && grep -q '"drift_ppm"' watch.json || fail "$(cat watch.json)"
[ "$(stat -c %a state/fovead)" = 700 ] || fail "other users may read the rotation that is kept"
sed -n 2p state/fovead/recentre >kept
[ "$(wc -w <kept)" = 4 ] || fail "$(cat state/fovead/recentre)"

# The recording holds what the device sent: recentring neither changes the recording nor its replay.
grep -q 'recorded [1-9]' recorded || fail "$(cat recorded)"
"$foveactl" gaze info tracker.gaze >info
"$fovead" --scene room.obj --size 128x64 --gaze replay:tracker.gaze --clock virtual --json >replay.json 2>/dev/null
[ "$(number gaze_valid replay.json)" -ge 10 ] || fail "$(cat replay.json)"

# turned FOLDER: print the direction of the resting gaze, with the rotation that is kept in FOLDER.
turned() {
    XDG_STATE_HOME="$1" umockdev-wrapper "$programs/device_plug" still:100 run -- sh -c '
        "$1" --scene room.obj --size 128x64 --gaze hid >daemon.out 2>daemon.err &
        daemon=$!
        until "$2" --wait watch --json --for 0.5 >resting.json; grep -q "\"state\": \"fixation\"" resting.json; do :; done
        kill $daemon; wait $daemon' sh "$fovead" "$foveactl" 2>plug.err || fail "$(cat plug.err)"
    grep -A 2 gaze_deg resting.json | tail -n 2 | tr -d ' \n' | awk -F, '{printf "%.0f %.0f\n", $1, $2}'
}
printf 'fovead-recentre 1\n0 -0.0871557427 0 0.996194698\n' >state/fovead/recentre # ten degrees to the right
plain=$(turned "$place/nothing")
right=$(turned "$place/state")
set -- $plain $right
[ $(($3 - $1)) -ge 9 ] && [ $(($3 - $1)) -le 11 ] || fail "from $plain to $right, not ten degrees to the right"
