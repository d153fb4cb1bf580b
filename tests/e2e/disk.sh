#!/bin/sh
# Writing to a disk of 64 KiB: no program reports success for a file that is not whole, and no old file is lost.
[ -n "${DISK_OWN-}" ] || {
    export DISK_OWN=1
    # Mounts that nobody else sees, and that go with this script.
    for unshare in 'unshare -m' 'unshare -rm'; do
        $unshare sh -c 'd=$(mktemp -d) && mount -t tmpfs -o size=64k none "$d" && umount "$d" && rmdir "$d"' 2>/dev/null &&
            exec $unshare sh "$0" "$@"
    done
    echo "no disk of 64 KiB can be mounted here: left out"
    exit 77
}
. "$(dirname "$0")/common.sh"
make_room
make_log
small="--scene room.obj --size 256x128"
mkdir full
mount -t tmpfs -o size=64k none full
trap 'status=$?; set +e; umount -l "$place/full"; (exit $status); finish' EXIT

# fill BYTES: leave about so many bytes free, in whole pages.
fill() {
    rm -f full/filler
    free=$(($(stat -f -c '%a * %S' full)))
    head -c $((free - $1)) /dev/zero >full/filler
}

# lost WORD FILE COMMAND...: the command writes to FILE and has no room: it fails with that word and leaves what was
# there, and nothing else.
lost() {
    word=$1
    file=$2
    shift 2
    rm -f full/filler
    echo "precious" >"$file"
    fill 0
    ls -A full >before.ls
    refused "$word" "$@"
    [ "$(cat "$file")" = precious ] || fail "lost what was in $file: $*"
    ls -A full >after.ls
    cmp -s before.ls after.ls || fail "left behind by $*: $(cat after.ls)"
    rm "$file"
    fill 0
    ls -A full >before.ls
    refused "$word" "$@"
    ls -A full >after.ls
    cmp -s before.ls after.ls || fail "left behind by $*: $(cat after.ls)"
}
space='No space left on device'

# Pictures, of the daemon and of its client.
"$fovead" $small --until 2spp --save good.exr >/dev/null 2>&1
"$fovead" $small --until 1spp --save other.exr >/dev/null 2>&1
export fovead small
printf '#!/bin/sh\n"$fovead" $small --until 1spp --save full/end.exr 2>end.all >end.out; s=$?; grep -v " %% " end.all >&2; exit $s\n' >save_at_end.sh
lost "$space" full/end.exr sh save_at_end.sh
start $small --gaze synthetic:2
lost "$space" full/save.exr "$foveactl" save full/save.exr
for end in exr png jpg jpeg; do
    lost "$space" full/panorama.$end "$foveactl" snapshot full/panorama.$end --settle 0
    lost "$space" full/view.$end "$foveactl" snapshot full/view.$end --settle 0 --view 0,0,90 --size 300x200
done
lost "$space" full/samples.png "$foveactl" samples good.exr full/samples.png --gaze short.gaze
lost "$space" full/map.png "$foveactl" compare good.exr other.exr --map full/map.png

# At intervals: a full disk is told once, the old file stays, and rendering goes on until there is room.
rm -f full/*
echo precious >full/auto.jpg
fill 0
kill -TERM "$daemon"
wait "$daemon" || fail "the daemon ended with status $?"
start --scene room.obj --size 128x64 --gaze synthetic:2 --save full/auto.jpg --save-every 1
await 'a word on the full disk' grep -q "full/auto.jpg: cannot be written: $space" daemon.err
sleep 2.5
[ "$(cat full/auto.jpg)" = precious ] || fail 'lost what was in auto.jpg'
"$foveactl" stats >/dev/null || fail 'the daemon does not go on'
rm full/filler
await 'a word that it works' grep -q 'the film is saved again: wrote full/auto.jpg' daemon.err
"$programs/e2e_picture" full/auto.jpg 128 64 >/dev/null || fail 'no whole picture'
[ "$(wc -l <daemon.err)" = 2 ] || fail "not two lines: $(cat daemon.err)"
stop
rm -f full/*
start $small --gaze synthetic:2

# Logs, their sidecars and charts.
lost "$space" full/log.gaze "$foveactl" gaze convert short.gaze full/log.gaze --replace
lost "$space" full/x_physio.tsv.gz "$foveactl" gaze convert short.gaze full/x_physio.tsv.gz --replace
lost "$space" full/x_physio.json "$foveactl" gaze convert short.gaze full/x_physio.tsv.gz --replace
if command -v gnuplot >/dev/null; then
    lost "$space" full/plot.svg "$foveactl" gaze plot short.gaze full/plot.svg
    lost "$space" full/plot.png "$foveactl" gaze plot short.gaze full/plot.png
    if [ -x "$programs/fovea-bench" ]; then
        lost "$space" full/bench.svg "$programs/fovea-bench" foveation --seconds 20 --plot full/bench.svg
    fi
else
    echo "no gnuplot here: charts are left out"
fi
lost "$space" full/hall.gaze "$programs/make_gaze" full/hall.gaze

# What is printed to a file on it.
for command in "$fovead --help" "$foveactl --help" "$foveactl stats" "$foveactl stats --json" "$foveactl gaze info short.gaze" \
    "$foveactl compare good.exr other.exr" "$foveactl watch --for 0.5"; do
    status=0
    $command >full/filler 2>printed.err || status=$?
    fill 0
    $command >>full/filler 2>printed.err && fail "success on a full disk: $command"
    grep -q "the output cannot be written: $space" printed.err || fail "$command: $(cat printed.err)"
done

# A picture on a disk with more and more room: it is the picture, or the old one and an error.
"$foveactl" samples good.exr whole.png >/dev/null
pages=$(($(wc -c <whole.png) / 4096))
[ "$pages" -lt 12 ] || fail "the picture fills the disk: $pages pages"
for left in $(seq 0 $((pages + 2))); do
    rm -f full/*
    echo precious >full/a.png
    fill $((4096 * left))
    if "$foveactl" samples good.exr full/a.png >said 2>&1; then
        cmp full/a.png whole.png || fail "success, and not the picture, with $left pages"
        last=$left
    else
        [ "$(cat full/a.png)" = precious ] || fail "lost what was there, with $left pages: $(cat said)"
    fi
    [ "$(ls -A full | wc -l)" -le 2 ] || fail "left behind: $(ls -A full)"
done
[ "${last-}" = $((pages + 2)) ] || fail "never enough room for $pages pages"
rm -f full/*

# A recording cannot begin, and the old one stays.
lost "$space" full/r.gaze "$foveactl" record full/r.gaze --replace
lost "$space" full/r.gaze "$fovead" $small --gaze synthetic:2 --record full/r.gaze --replace --listen "unix:$place/other"
grep -q 'lost' daemon.err && fail "a recording that has not begun loses something: $(cat daemon.err)"

# A recording that fills the disk says so, loses what does not fit into its queue, and goes on when there is room.
rm -f full/*
fill 8192
"$foveactl" record full/r.gaze --for 3600 >record.out 2>record.err &
recorder=$!
await 'a word on the full disk' grep -qs "$space" daemon.err
grep -q "$place/full/r.gaze: cannot write: $space" daemon.err || fail "$(cat daemon.err)"
await 'a word to the client' grep -qs "$space" record.err
"$foveactl" stats --json >full.json
grep -q '"recording_error": "[^"]*No space left' full.json || fail "stats do not say it: $(cat full.json)"
"$foveactl" stats | grep -q "lost: .*$space" || fail "stats do not say it"
rm full/filler
before=$(number recorded full.json)
await 'the recording to go on' told going.json recorded $((before + 1))
await 'a word on it' grep -q 'the recording goes on' daemon.err
lost=$(number recording_lost going.json)
kill -TERM $recorder
status=0
wait $recorder || status=$?
[ "$status" = "$([ "$lost" = 0 ] && echo 0 || echo 1)" ] || fail "status $status with $lost lost: $(cat record.err)"
"$foveactl" gaze info --json full/r.gaze >info.json
[ "$(number samples info.json)" -gt "$before" ] || fail "$(cat info.json)"

# One that is full until the end is not a success, and what is there is whole.
rm -f full/*
fill 8192
"$foveactl" record full/last.gaze >/dev/null
cp daemon.err old.err
await 'a word on the full disk' grep -q 'last.gaze: cannot write' daemon.err
kill -TERM "$daemon"
status=0
wait "$daemon" || status=$?
daemon=
[ "$status" = 1 ] || fail "the daemon ended with status $status, and the recording is not whole"
grep -q "recorded [1-9][0-9]* samples to $place/full/last.gaze, [1-9][0-9]* lost: .*$space" daemon.err || fail "$(cat daemon.err)"
kept=$(sed -n 's/.*recorded \([0-9]*\) samples to .*last.gaze.*/\1/p' daemon.err)
"$foveactl" gaze info --json full/last.gaze >info.json
[ "$(number samples info.json)" = "$kept" ] || fail "$kept were said to be kept: $(cat info.json)"
