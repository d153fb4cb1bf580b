#!/bin/sh
# From samples to an aim: what the stream tells of the decisions, freezing, recentring, and the list of trackers.
. "$(dirname "$0")/common.sh"
make_room
export XDG_STATE_HOME="$place/state"
small="--scene room.obj --size 256x128 --bounces 1" # the picture matters little

# field KEY FILE: print the text of this key in a JSON file. pair KEY FILE: print its two numbers.
field() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$2"; }
# heard STATE FILE: print how often this state was in the stream.
heard() { sed -n "/\"states\"/,/}/s/.*\"$1\": \([0-9]*\).*/\1/p" "$2"; }
pair() { grep -A 2 "\"$1\"" "$2" | tail -n 2 | tr -d ' \n'; }

# A blink, and then an eye that is not seen for three seconds, in a loop: a client that connects late or misses one sees
# the next.
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
# --raw-gaze and --predict give other pictures than the default, and the same options give the same picture again.
for options in "" "--raw-gaze" "--predict" "--predict"; do
    "$fovead" $small --gaze replay:blinks.gaze --clock virtual --until 1.5s $options --save now.exr >/dev/null
    md5sum <now.exr >>pictures
done
[ "$(sort -u pictures | wc -l)" = 3 ] && [ "$(tail -n 2 pictures | sort -u | wc -l)" = 1 ] || fail "pictures: $(cat pictures)"

# One eye steers as well as both together (1), whether it is the left one (16) or the right one (256), and as many
# samples count as valid.
for bit in 1 16 256; do
    awk -v bit=$bit 'NR > 2 && $4 {$4 = $4 % 2 ? bit : 0} NR <= 242' "$source/fixtures/hall.gaze" >one.gaze
    "$fovead" $small --gaze replay:one.gaze --clock virtual --json >one.json
    number gaze_valid one.json
done >valid
[ "$(sort -u valid | wc -l)" = 1 ] && [ "$(head -n 1 valid)" -gt 100 ] || fail "valid samples: $(cat valid)"

# While frozen, the direction stays although samples arrive. Afterwards it follows again.
start $small --gaze synthetic:4
is_frozen() { [ "$(field state "$1")" = frozen ]; }
goes_on() { is_frozen second.json && [ "$(number gaze_samples second.json)" -gt $(($(number gaze_samples first.json) + 100)) ]; }
is_free() { [ -n "$(field state third.json)" ] && ! is_frozen third.json && [ "$(pair gaze_deg third.json)" != "$(pair gaze_deg second.json)" ]; }
"$foveactl" freeze
await 'a frozen gaze' watched first.json is_frozen first.json
await 'samples of a frozen gaze' watched second.json goes_on
[ "$(pair gaze_deg first.json)" = "$(pair gaze_deg second.json)" ] || fail "the gaze moves while it is frozen: $(cat second.json)"
"$foveactl" unfreeze
await 'a gaze that moves again' watched third.json is_free

# recentre [WHERE]: try again while the eye is not at rest. A synthetic observer rests most of the time.
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
# The eye may have moved on since: the answer is either a success or that the turn is too large.
recentre "$1,$2" || grep -q 'at most 20' why || fail "$(cat why)"
if recentre "$(awk -v yaw="$1" 'BEGIN {print yaw + 180}'),0"; then fail "a turn of half a circle was accepted: $(cat said)"; fi
grep -q 'at most 20' why || fail "$(cat why)"
refused 'recentre wants' "$foveactl" recentre up
refused usage "$foveactl" recentre 1,2 3
[ ! -e state ] || fail "a rotation was kept although no tracker is in use"

# Keys of watch in a terminal, whose settings are the same afterwards. Each key is pressed when the answer to the last
# one shows.
shows() { await "'$1' on the terminal" grep -q "$1" keys.txt; }
# A step ahead and a step to the right are at a right angle, whatever the view.
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

# A broken rotation gives one line and is ignored. Recordings do not use the rotation.
mkdir -p state/fovead
echo nonsense >state/fovead/recentre
"$fovead" $small --gaze auto --until 0.2s >/dev/null 2>broken.err || fail "$(cat broken.err)"
[ "$(grep -c "$place/state/fovead/recentre" broken.err)" = 1 ] || fail "$(cat broken.err)"
"$fovead" $small --gaze replay:blinks.gaze --until 0.2s >/dev/null 2>broken.err
[ ! -s broken.err ] || fail "$(cat broken.err)"

# The test does not know what is plugged in here, but the list must work, for people and for scripts.
"$fovead" --list-trackers >list.txt
grep -q -e 'no eye tracker' -e '--gaze' list.txt || fail "$(cat list.txt)"
"$fovead" --list-trackers --json | grep -q '"trackers": \[' || fail "no list in JSON"

# wrong WORD OPTION...: refused with one line and status 2.
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
