#!/bin/sh
# Gaze at a screen goes through the view of the client that steers: which client that is, and where the aim then is.
. "$(dirname "$0")/common.sh"
make_room
small="--scene room.obj --size 256x128 --bounces 1" # the picture matters little

# looks X Y FILE: ten seconds of an eye that looks at one point of a screen, as a Gazepoint tracker records it.
looks() {
    awk -v x="$1" -v y="$2" 'BEGIN {
        print "CNT,TIME(2020/01/31 10:00:00.000),FPOGX,FPOGY,FPOGV,BPOGX,BPOGY,BPOGV"
        for (i = 0; i < 600; i++) printf "%d,%.5f,%s,%s,1,%s,%s,1\n", i, i / 60, x, y, x, y
    }' >"$3"
}
# aims YAW PITCH FILE: in degrees, to a tenth.
aims() {
    grep -A 2 '"gaze_deg"' "$3" | tail -n 2 | tr -d ' ,' | paste -sd ' ' - |
        awk -v yaw="$1" -v pitch="$2" '{exit !(($1 - yaw) ^ 2 < 0.01 && ($2 - pitch) ^ 2 < 0.01)}'
}
field() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$2"; }
# shows NAME YAW,PITCH,WIDTH,HEIGHT [OPTION...]: a viewer, in the background; what it is told is in NAME.view.
shows() {
    viewer=$1
    shift
    "$foveactl" view "$@" >"$viewer.view" 7>&- & # 7: what keeps the headset on
    eval "$viewer=$!"
}
leaves() {
    eval "kill \$$1 && wait \$$1"
}
# told NAME TEXT: is that what the viewer was told last?
hears() { tail -n 1 "$1.view" | grep -qF -e "$2"; }

# The middle of the screen, then its right edge, through a view that is turned to the right. Without a view the screen is
# a window: its right edge is 21.8 degrees to the right, by the size that is assumed.
looks 0.5 0.5 middle.csv
looks 1 0.5 edge.csv
start $small --gaze replay:middle.csv --loop
await 'an aim ahead' watched watch.json aims 0 0 watch.json
shows first 90,0,90,60
await 'an aim at the middle of the view' watched watch.json aims 90 0 watch.json
[ "$(field viewer watch.json)" != '' ] || fail "nobody is told who steers: $(cat watch.json)"
stop
wait "$first" || fail 'the viewer does not end in order with the daemon'
start $small --gaze replay:edge.csv --loop
await 'an aim at its true angle' watched watch.json aims 21.8 0 watch.json
shows first 90,0,90,60
await 'an aim at the edge of the view' watched watch.json aims 135 0 watch.json
await 'a word on who steers' hears first 'this view steers'

# The latest to ask steers, and who was there before is told; when it goes, the former steers again.
shows second -90,80,60,60 --at 0.5,0,0.5,1
await 'an aim in the second view' watched watch.json aims -16.74 58.53 watch.json
await 'a word to the second' hears second 'this view steers'
await 'a word to the first' hears first 'the view is steered by '
hears first 'foveactl view' || fail "the first is told: $(cat first.view)"
leaves second
await 'an aim in the first view' watched watch.json aims 135 0 watch.json
await 'a word to the first again' hears first 'this view steers'
kill -9 "$first"
wait "$first" || true
await 'an aim without views' watched watch.json aims 21.8 0 watch.json
[ "$(field viewer watch.json)" = '' ] || fail "a view has stayed: $(cat watch.json)"

# A headset steers before windows, whoever asks, until it is taken off.
shows first 90,0,90,60
await 'an aim in the first view' watched watch.json aims 135 0 watch.json
mkfifo worn
"$programs/e2e_viewer" "unix:$place/fovead.sock" headset 30 <worn >headset.view &
headset=$!
exec 7>worn
await 'an aim where the head points' watched watch.json aims 75 0 watch.json
await 'a word to the headset' hears headset mine
await 'a word on the headset' hears first 'the view is steered by '
shows second 0,0,90,60
await 'a word on the headset to the second' hears second 'the view is steered by '
watched watch.json aims 75 0 watch.json || fail "a window has taken the view from the headset: $(cat watch.json)"
exec 7>&-
wait "$headset" || fail 'the headset'
await 'an aim in the second view' watched watch.json aims 45 0 watch.json
leaves second
leaves first

# Beside the window with the view nothing is looked at: the aim waits in the view, and says why.
shows first 90,0,90,60 --at 0,0,0.5,1
waits() { [ "$(field why watch.json)" = 'the eye looks beside the view' ] && aims 90 0 watch.json; }
await 'an eye beside the view' watched watch.json waits
leaves first
stop

# A recording keeps the point on the screen, so that it can be seen through another view.
looks 0.75 0.5 right.csv
start $small --gaze replay:right.csv --loop
shows first 90,0,90,60
await 'an aim in the view' watched watch.json aims 116.6 0 watch.json
"$foveactl" record kept.gaze --for 0.5 >/dev/null
leaves first
stop
start $small --gaze replay:kept.gaze --loop
grep -q 'gaze at a screen' daemon.out || "$foveactl" stats | grep -q 'gaze at a screen' || fail "$(cat daemon.out)"
shows first 0,0,90,60 --at 0.5,0.25,0.5,0.5
await 'an aim in another view' watched watch.json aims 0 0 watch.json
leaves first
stop

# Under the virtual clock a picture does not depend on clients.
start $small --gaze replay:edge.csv --loop --clock virtual --until 100000s --listen "unix:$place/fovead.sock"
shows first 90,0,90,60
await 'a word on the virtual clock' hears first 'the view is steered by the virtual clock'
await 'an aim at its true angle' watched watch.json aims 21.8 0 watch.json
leaves first
stop

for bad in 1,2,3 0,91,90,60 0,0,0,60 0,0,90,180 0,0,nan,60; do refused 'YAW,PITCH,WIDTH,HEIGHT' "$foveactl" view "$bad"; done
for bad in 0,0,1 0,0,0,1 0,0,1,-1 0,0,101,1; do refused 'LEFT,TOP,WIDTH,HEIGHT' "$foveactl" view 0,0,90,60 --at "$bad"; done
