#!/bin/sh
# From samples to a gaze to render for: what is decided and why is in the stream; freezing, recentring, listing trackers.
. "$(dirname "$0")/common.sh"
make_room
export XDG_STATE_HOME="$place/state"
small="--scene room.obj --size 256x128"

# field KEY FILE: the text of that key in a JSON file; pair: its two numbers.
field() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$2"; }
# heard STATE FILE: how often it was in the stream.
heard() { sed -n "/\"states\"/,/}/s/.*\"$1\": \([0-9]*\).*/\1/p" "$2"; }
pair() { grep -A 2 "\"$1\"" "$2" | tail -n 2 | tr -d ' \n'; }

# A blink, then an eye that is not seen for three seconds.
awk 'NR > 480 && NR <= 840 {$4 = 0} NR <= 880' "$source/fixtures/hall.gaze" >blinks.gaze
start $small --gaze replay:blinks.gaze
timeout 60 "$foveactl" watch --until-finished --json >states.json
for state in fixation saccade blink lost fallback; do
    [ "$(heard $state states.json)" -gt 0 ] || fail "no $state in the stream: $(cat states.json)"
done
[ "$(heard frozen states.json)" = 0 ] || fail "$(cat states.json)"
[ "$(field source states.json)" = 'both eyes' ] && [ -n "$(field why states.json)" ] || fail "$(cat states.json)"
stop
# Every sample as it is measured, and where a saccade will land, are other pictures than what is usual; both are as
# certain as that.
for options in "" "--raw-gaze" "--predict" "--predict"; do
    "$fovead" $small --gaze replay:blinks.gaze --clock virtual --until 1.5s $options --save now.exr >/dev/null
    md5sum <now.exr >>pictures
done
[ "$(sort -u pictures | wc -l)" = 3 ] && [ "$(tail -n 2 pictures | sort -u | wc -l)" = 1 ] || fail "pictures: $(cat pictures)"

# Frozen, the direction stays while samples come; then it follows again.
start $small --gaze synthetic:4
"$foveactl" --wait watch --for 0.5 --json >free.json
"$foveactl" freeze
"$foveactl" watch --for 0.3 --json >first.json
"$foveactl" watch --for 2 --json >second.json
[ "$(pair gaze_deg first.json)" = "$(pair gaze_deg second.json)" ] || fail "frozen, and the gaze moves: $(cat second.json)"
[ "$(field state second.json)" = frozen ] && [ "$(heard frozen second.json)" -gt 60 ] || fail "$(cat second.json)"
[ "$(number gaze_samples second.json)" -gt "$(number gaze_samples first.json)" ] || fail "samples stopped"
"$foveactl" unfreeze
"$foveactl" watch --for 2 --json >third.json
[ "$(pair gaze_deg third.json)" != "$(pair gaze_deg second.json)" ] && [ "$(field state third.json)" != frozen ] ||
    fail "still frozen: $(cat third.json)"

# recentre WHERE: at rest it is done; a synthetic observer rests most of the time.
recentre() {
    tries=0
    until "$foveactl" recentre "$@" >said 2>why; do
        grep -q 'not at rest' why || return 1
        tries=$((tries + 1))
        [ "$tries" -lt 100 ] || fail "no rest: $(cat why)"
        sleep 0.1
    done
}
recentre || grep -q 'at most 20' why || fail "$(cat why)"
"$foveactl" watch --for 0.1 --json >where.json
at=$(pair gaze_deg where.json)
set -- $(echo "$at" | tr , ' ')
# The eye may have moved on meanwhile: only that it is one of the two answers.
recentre "$1,$2" || grep -q 'at most 20' why || fail "$(cat why)"
if recentre "$(awk -v yaw="$1" 'BEGIN {print yaw + 180}'),0"; then fail "a turn by half a circle: $(cat said)"; fi
grep -q 'at most 20' why || fail "$(cat why)"
refused 'recentre wants' "$foveactl" recentre up
refused usage "$foveactl" recentre 1,2 3
[ ! -e state ] || fail "what is no tracker's was kept"

# Keys, on a terminal, which is as before afterwards; each is pressed when the answer to the one before is to be seen.
shows() {
    tries=0
    until grep -q "$1" keys.txt || [ $((tries += 1)) -gt 200 ]; do sleep 0.1; done
}
: >keys.txt
(shows 'f freeze'; printf f; shows 'f unfreeze'; printf c; shows 'recentre: gaze is\|gaze is turned by'
    printf 'w\033[C'; sleep 1; printf q) |
    script -qec "sh -c 'stty -g >before; timeout --foreground 90 \"$foveactl\" watch; stty -g >after'" /dev/null >>keys.txt
cmp before after
grep -q 'f freeze, c recentre, .* q quit' keys.txt && grep -q 'f unfreeze' keys.txt || fail "keys: $(tail -n 20 keys.txt)"
grep -q 'recentre: gaze is\|gaze is turned by' keys.txt || fail "no answer to c: $(tail -n 20 keys.txt)"
"$foveactl" stats --json | grep -q '"frozen": true' || fail "f does not freeze"
# A step ahead and one to the right are square to each other.
"$foveactl" stats --json | grep -A 3 '"eye"' | tr -d '", ' | awk '{s += $1 * $1} END {exit !(s > 0.12 && s < 0.13)}' ||
    fail "w and the arrow do not move the eye: $("$foveactl" stats)"
stop
[ "$(wc -l <daemon.err)" = 0 ] || fail "the daemon complains: $(cat daemon.err)"

# A rotation that is broken is told in one line, and nothing more comes of it; recordings have no use for one.
mkdir -p state/fovead
echo nonsense >state/fovead/recentre
"$fovead" $small --gaze auto --until 0.2s >/dev/null 2>broken.err || fail "$(cat broken.err)"
[ "$(grep -c "$place/state/fovead/recentre" broken.err)" = 1 ] || fail "$(cat broken.err)"
"$fovead" $small --gaze replay:blinks.gaze --until 0.2s >/dev/null 2>broken.err
[ ! -s broken.err ] || fail "$(cat broken.err)"

# What is plugged in here is not known, but it is listed, for people and for scripts.
"$fovead" --list-trackers >list.txt
grep -q -e 'no eye tracker' -e '--gaze' list.txt || fail "$(cat list.txt)"
"$fovead" --list-trackers --json | grep -q '"trackers": \[' || fail "no list in JSON"

# one line and status 2.
wrong() {
    word=$1
    shift
    refused "$word" "$fovead" $small "$@"
    [ "$status" = 2 ] || fail "status $status, where 2 was expected: $*"
}
wrong --screen --gaze hid --screen 1,2
wrong 0.01 --gaze hid --screen 1,2,0
wrong --screen --gaze synthetic --screen 1,1,1
wrong --calibration --gaze hid --calibration x
wrong --raw-gaze --gaze pointer --raw-gaze
wrong --predict --until 1spp --predict
wrong --record --until 1spp --record x.gaze
wrong --replace --gaze synthetic --replace
refused no/such "$fovead" $small --gaze psvr2 --calibration no/such
