#!/bin/sh
# From samples to an aim: the stream tells what is decided and why; freezing, recentring, listing trackers.
. "$(dirname "$0")/common.sh"
make_room
export XDG_STATE_HOME="$place/state"
small="--scene room.obj --size 256x128 --bounces 1" # the picture matters little

# field KEY FILE: the text of that key in a JSON file; pair: its two numbers.
field() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$2"; }
# heard STATE FILE: how often it was in the stream.
heard() { sed -n "/\"states\"/,/}/s/.*\"$1\": \([0-9]*\).*/\1/p" "$2"; }
pair() { grep -A 2 "\"$1\"" "$2" | tail -n 2 | tr -d ' \n'; }

# A blink, then an eye that is not seen for three seconds, and that again and again: a client that comes late, or is
# passed over, hears of it the next time.
awk 'NR > 480 && NR <= 840 {$4 = 0} NR <= 880' "$source/fixtures/hall.gaze" >blinks.gaze
start $small --gaze replay:blinks.gaze --loop
hears() { [ "$(heard "$1" states.json)" -gt 0 ]; }
sees_both() { [ "$(field source states.json)" = 'both eyes' ]; }
for state in fixation saccade blink lost fallback; do
    await "$state in the stream" watched states.json hears $state
    [ "$(heard frozen states.json)" = 0 ] || fail "$(cat states.json)"
done
await 'both eyes' watched states.json sees_both
[ -n "$(field why states.json)" ] || fail "$(cat states.json)"
stop
# Every sample as it is measured, and where a saccade will land, are other pictures than what is usual; both are as
# certain as that.
for options in "" "--raw-gaze" "--predict" "--predict"; do
    "$fovead" $small --gaze replay:blinks.gaze --clock virtual --until 1.5s $options --save now.exr >/dev/null
    md5sum <now.exr >>pictures
done
[ "$(sort -u pictures | wc -l)" = 3 ] && [ "$(tail -n 2 pictures | sort -u | wc -l)" = 1 ] || fail "pictures: $(cat pictures)"

# One eye steers as both do together (1), be it the left (16) or the right (256), and its samples count as much.
for bit in 1 16 256; do
    awk -v bit=$bit 'NR > 2 && $4 {$4 = $4 % 2 ? bit : 0} NR <= 242' "$source/fixtures/hall.gaze" >one.gaze
    "$fovead" $small --gaze replay:one.gaze --clock virtual --json >one.json
    number gaze_valid one.json
done >valid
[ "$(sort -u valid | wc -l)" = 1 ] && [ "$(head -n 1 valid)" -gt 100 ] || fail "valid samples: $(cat valid)"

# Frozen, the direction stays while samples come; then it follows again.
start $small --gaze synthetic:4
is_frozen() { [ "$(field state "$1")" = frozen ]; }
goes_on() { is_frozen second.json && [ "$(number gaze_samples second.json)" -gt $(($(number gaze_samples first.json) + 100)) ]; }
is_free() { [ -n "$(field state third.json)" ] && ! is_frozen third.json && [ "$(pair gaze_deg third.json)" != "$(pair gaze_deg second.json)" ]; }
"$foveactl" freeze
await 'a frozen gaze' watched first.json is_frozen first.json
await 'samples of a frozen gaze' watched second.json goes_on
[ "$(pair gaze_deg first.json)" = "$(pair gaze_deg second.json)" ] || fail "frozen, and the gaze moves: $(cat second.json)"
"$foveactl" unfreeze
await 'a gaze that moves again' watched third.json is_free

# recentre WHERE: at rest it is done; a synthetic observer rests most of the time.
recentre() {
    await 'an eye at rest' recentred "$@"
    [ ! -s why ]
}
recentred() { "$foveactl" recentre "$@" >said 2>why || ! grep -q 'not at rest' why; }
recentre || grep -q 'at most 20' why || fail "$(cat why)"
has_gaze() { [ -n "$(field state where.json)" ]; }
await 'a gaze' watched where.json has_gaze
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
shows() { await "'$1' on the terminal" grep -q "$1" keys.txt; }
# A step ahead and one to the right are square to each other.
moved() { "$foveactl" stats --json | grep -A 3 '"camera"' | tr -d '", ' | awk '{s += $1 * $1} END {exit !(s > 0.12 && s < 0.13)}'; }
: >keys.txt
(shows 'f freeze'; printf f; shows 'f unfreeze'; printf c; shows 'recentre: gaze is\|gaze is turned by'
    printf 'w\033[C'; await 'w and the arrow to move the camera' moved; printf q) |
    script -qec "sh -c 'stty -g >before; \"$foveactl\" watch; stty -g >after'" /dev/null >>keys.txt
cmp before after
grep -q 'f freeze, c recentre, .* q quit' keys.txt && grep -q 'f unfreeze' keys.txt || fail "keys: $(tail -n 20 keys.txt)"
grep -q 'recentre: gaze is\|gaze is turned by' keys.txt || fail "no answer to c: $(tail -n 20 keys.txt)"
"$foveactl" stats --json | grep -q '"frozen": true' || fail "f does not freeze"
moved || fail "w and the arrow do not move the camera: $("$foveactl" stats)"
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
