#!/bin/sh
# Recording gaze: a recording replays as it was, and a daemon that is killed loses at most the last second of it.
. "$(dirname "$0")/common.sh"
make_room
make_log
small="--scene room.obj --size 256x128 --bounces 1" # the picture matters little
tcp=tcp:localhost:$("$programs/e2e_port")

# The recording of a replay equals the log, and gives the same picture.
"$fovead" $small --gaze replay:short.gaze --clock virtual --record copy.gaze --save a.exr >/dev/null
"$fovead" $small --gaze replay:copy.gaze --clock virtual --save b.exr >/dev/null
cmp a.exr b.exr
for log in short copy; do "$foveactl" gaze convert $log.gaze $log-again.gaze >/dev/null; done
cmp short-again.gaze copy-again.gaze || fail "the recording is not the log"
refused copy.gaze "$fovead" $small --gaze replay:short.gaze --until 1spp --record copy.gaze
refused no/such "$fovead" $small --gaze replay:short.gaze --until 1spp --record no/such/copy.gaze
"$fovead" $small --gaze replay:short.gaze --clock virtual --record copy.gaze --replace --json >json 2>err
grep -q "recorded 120 samples to copy.gaze" err || fail "$(cat err)"

# A client records while the daemon runs.
start $small --gaze synthetic:2 --listen "unix:$place/fovead.sock" --listen "$tcp"
"$foveactl" record mine.gaze | grep -qF "recording to $place/mine.gaze" || fail "the answer does not name the file"
refused 'being recorded' "$foveactl" record other.gaze
[ ! -e other.gaze ] || fail "a second recording was started"
refused socket "$foveactl" record tcp.gaze --connect "$tcp"
refused socket "$foveactl" record --stop --connect "$tcp"
await 'a hundred samples' told stats.json recorded 101
grep -q "\"recording\": \"$place/mine.gaze\"" stats.json || fail "stats do not show the recording"
"$foveactl" record --stop >said
"$foveactl" gaze info --json mine.gaze >info.json
[ "recorded $(number samples info.json) samples to $place/mine.gaze" = "$(cat said)" ] || fail "$(cat said info.json)"
[ "$(number samples info.json)" -gt 100 ] || fail "$(cat info.json)"
refused 'not being recorded' "$foveactl" record --stop
refused exists "$foveactl" record mine.gaze
"$foveactl" record mine.gaze --replace --for 0.5 >said
[ "$(wc -l <said)" = 2 ] || fail "$(cat said)"
refused usage "$foveactl" record
refused usage "$foveactl" record a b
refused usage "$foveactl" record --stop mine.gaze
refused no/such "$foveactl" record no/such/mine.gaze
# A signal ends a recording just as --for does.
rm said
"$foveactl" record early.gaze --for 3600 >said &
recorder=$!
await 'a line on the recording' test -s said
await 'a sample' told stats.json recorded 1
kill -TERM $recorder
wait $recorder || fail "record ended with status $?"
grep -q 'recorded [1-9]' said || fail "$(cat said)"
# A recording that is still running when the daemon ends is whole.
"$foveactl" record last.gaze >/dev/null
await 'ten samples' told stats.json recorded 10
stop
grep -q "recorded [1-9][0-9]* samples to $place/last.gaze" daemon.out || fail "$(cat daemon.out)"
"$foveactl" gaze info last.gaze >/dev/null

# If the daemon is killed, all samples that it has reported as recorded are kept.
start $small --gaze synthetic:3 --record killed.gaze
await 'enough samples' told before.json recorded 300
kill -9 "$daemon"
wait "$daemon" || true
daemon=
"$foveactl" gaze info --json killed.gaze >info.json 2>info.err || fail "$(cat info.err)"
told=$(number recorded before.json)
kept=$(number samples info.json)
echo "killed after $told recorded samples: $kept are kept"
[ "$kept" -ge "$told" ] || fail "$kept samples are left of $told"
"$fovead" $small --gaze replay:killed.gaze --clock virtual --json >replay.json 2>replay.err
[ "$(number gaze_samples replay.json)" = "$kept" ] || fail "$(cat replay.json)"
# If a crash of the machine has cut the last line at any byte, that line is left out, and the program says so.
last=$(tail -n 1 killed.gaze | wc -c)
for torn in 1 40 $((last - 1)); do
    head -c "-$torn" killed.gaze >torn.gaze
    "$foveactl" gaze info --json torn.gaze >torn.json
    [ "$(number samples torn.json)" = $((kept - 1)) ] || fail "$torn bytes less: $(cat torn.json)"
    grep -q "line $((kept + 2)) was cut off and is left out" torn.json || fail "$torn bytes less: $(cat torn.json)"
done
head -n 32 killed.gaze | head -c -40 >torn.gaze
"$fovead" $small --gaze replay:torn.gaze --clock virtual --json >replay.json 2>replay.err
[ "$(number gaze_samples replay.json)" = 29 ] || fail "$(cat replay.json)"
grep -q "line 32 was cut off" replay.json || fail "a recording that was cut off is replayed without a word: $(cat replay.json)"
# The daemon also says what it assumes about a log.
"$fovead" $small --gaze "replay:$source/tests/fuzz/corpus/log/gazepoint.csv" --clock virtual >replay.out
grep -q "assumed: screen of 16:9 43.6 degrees wide" replay.out || fail "$(cat replay.out)"

# Files that show where somebody looked are readable only by this user. That holds for every program that writes them,
# whatever the umask, and also if they replace a file that others could read.
umask 0
private() { # COMMAND... FILE: makes the file, twice
    for file; do :; done
    for turn in 1 2; do
        [ "$turn" = 1 ] || chmod 0644 "$file"
        "$@" >private.out 2>&1 || fail "$*: $(cat private.out)"
        [ "$(stat -c %a "$file")" = 600 ] || fail "$*: the mode of $file is $(stat -c %a "$file")"
    done
}
record_log() { "$fovead" $small --gaze replay:short.gaze --clock virtual --replace --record "$1"; }
convert() { "$foveactl" gaze convert --replace short.gaze "$1"; }
sidecar() { convert "${1%.json}.tsv.gz"; }
plot() { "$foveactl" gaze plot short.gaze "$1"; }
samples() { "$foveactl" samples b.exr "$1" --gaze short.gaze; }
density() { "$foveactl" samples b.exr "$1"; }
private record_log mine.gaze
private convert again.gaze
private convert again_physio.tsv.gz
private sidecar again_physio.json
private samples samples.png
private density density.png
if command -v gnuplot >/dev/null; then private plot plot.svg; else echo 'no gnuplot: the mode of its chart is not tested'; fi
start $small --gaze synthetic:2
by_client() { "$foveactl" record --replace --for 0.1 "$1"; }
private by_client client.gaze
stop
# Others may still see the pictures that a user renders.
"$fovead" $small --gaze replay:short.gaze --clock virtual --save shared.exr >private.out 2>&1
[ "$(stat -c %a shared.exr)" = 666 ] || fail "the mode of a picture is $(stat -c %a shared.exr)"
