#!/bin/sh
# An eye tracker that comes while a recording is replayed, among umockdev's fake devices: the stream tells of it, what
# recentring does is kept for the next start, and its recording replays.
. "$(dirname "$0")/common.sh"
if ! [ -x "$programs/device_plug" ] || ! command -v umockdev-wrapper >/dev/null; then
    echo "skipped: umockdev is not installed (sh daemon/setup.sh tests)"
    exit 77
fi
# umockdev's preload comes before a sanitizer's library, and is not ours to be checked for leaks.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0:detect_leaks=0"
export XDG_STATE_HOME="$place/state"
make_room

# Slow enough that its eye, which goes around a circle of 9 degrees, counts as resting.
cat >clients.sh <<'END'
set -eu
"$1" --scene room.obj --size 256x128 --gaze auto >daemon.out 2>daemon.err &
daemon=$!
trap 'kill $daemon' EXIT
"$2" --wait stats --json >before.json
touch asked
tries=0
until "$2" stats --json >plugged.json; grep -q '"present": true' plugged.json && grep -q '"gaze": "eye tracker' plugged.json; do
    tries=$((tries + 1))
    [ "$tries" -lt 100 ]
    sleep 0.1
done
"$2" record tracker.gaze >/dev/null
until "$2" recentre 0,0 >said 2>why; do
    grep -q 'not at rest' why
    tries=$((tries + 1))
    [ "$tries" -lt 200 ]
    sleep 0.1
done
"$2" watch --for 1 --json >watch.json
"$2" record --stop >recorded
trap - EXIT
kill $daemon
wait $daemon
END
umockdev-wrapper "$programs/device_plug" run file:asked hid:25 wait:50 -- sh clients.sh "$fovead" "$foveactl" >plug.out 2>plug.err ||
    fail "$(cat plug.err daemon.err ./*.json why 2>/dev/null)"
grep -q 'hall.gaze.*no eye tracker found' before.json || fail "$(cat before.json)"
grep -q '^fovead: gaze: eye tracker Fovea Test Tracker' daemon.err || fail "not a word on the tracker: $(cat daemon.err)"
grep -q 'turned by [0-9.]* degrees, also after the next start' said || fail "$(cat said)"
grep -q '"tracker": {' watch.json && grep -q '"drift_ppm"' watch.json || fail "$(cat watch.json)"
[ "$(stat -c %a state/fovead)" = 700 ] || fail "others may look at what is kept"
sed -n 2p state/fovead/recentre >kept
[ "$(wc -w <kept)" = 4 ] || fail "$(cat state/fovead/recentre)"

# What was recorded is what the device said: recentring is not in it, nor what is replayed turned.
grep -q 'recorded [1-9]' recorded || fail "$(cat recorded)"
"$foveactl" gaze info tracker.gaze >info
"$fovead" --scene room.obj --size 128x64 --gaze replay:tracker.gaze --clock virtual --json >replay.json 2>/dev/null
[ "$(number gaze_valid replay.json)" -gt 10 ] || fail "$(cat replay.json)"

# turned FOLDER: the mean direction, from one circle to the next, with what is kept there.
turned() {
    XDG_STATE_HOME="$1" umockdev-wrapper "$programs/device_plug" hid:100 run wait:20 -- sh -c '
        "$1" --scene room.obj --size 128x64 --gaze hid >daemon.out 2>daemon.err &
        daemon=$!
        "$2" --wait watch --for 0.5 >/dev/null
        for i in 1 2 3 4 5 6 7 8 9 10; do "$2" watch --json --for 0.5 | grep -A 2 gaze_deg | tail -n 2 | tr -d " \n"; echo; done
        kill $daemon; wait $daemon' sh "$fovead" "$foveactl" 2>plug.err |
        awk -F, '{x += $1; y += $2; n++} END {printf "%.0f %.0f\n", x / n, y / n}'
}
printf 'fovead-recentre 1\n0 -0.0871557427 0 0.996194698\n' >state/fovead/recentre # ten degrees to the right
plain=$(turned "$place/nothing")
right=$(turned "$place/state")
set -- $plain $right
[ $(($3 - $1)) -ge 8 ] && [ $(($3 - $1)) -le 12 ] || fail "from $plain to $right, not ten degrees to the right"
