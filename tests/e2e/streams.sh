#!/bin/sh
# How programs deal with their surroundings: closed descriptors, output that cannot be written, signals that arrive
# together, daemons that die, and pictures that never rest.
# If this test runs under nohup, its programs must not.
[ -n "${DEFAULT_SIGNALS-}" ] || DEFAULT_SIGNALS=1 exec env --default-signal=HUP sh "$0" "$@"
. "$(dirname "$0")/common.sh"
make_room
make_log
small="--scene room.obj --size 256x128"

# Closed descriptors: no other output may get into a recording or a picture.
"$fovead" $small --gaze replay:short.gaze --clock virtual --record open.gaze --save open.exr >/dev/null
for closed in '<&-' '>&-' '<&- >&-' '<&- >&- 2>&-'; do
    rm -f closed.gaze closed.exr closed.png
    eval '"$fovead" $small --gaze replay:short.gaze --clock virtual --record closed.gaze --save closed.exr 2>closed.err >closed.out '"$closed" ||
        fail "status $? with $closed: $(cat closed.err)"
    cmp open.gaze closed.gaze && cmp open.exr closed.exr || fail "not the same with $closed"
    eval '"$foveactl" samples closed.exr closed.png 2>closed.err >closed.out '"$closed" || fail "status $? with $closed: $(cat closed.err)"
    "$programs/e2e_picture" closed.png 256 128 >/dev/null
done

# Output that cannot be written is an error in every program and in every command that prints.
unwritten() {
    status=0
    "$@" >/dev/full 2>unwritten.err || status=$?
    [ "$status" = 1 ] && grep -q 'the output cannot be written: No space left on device$' unwritten.err ||
        fail "status $status of $* >/dev/full: $(cat unwritten.err)"
}
start $small --gaze synthetic:2
for program in fovead foveactl foveactl-image fovea-bench; do
    [ ! -x "$programs/$program" ] || unwritten "$programs/$program" --help
done
unwritten "$fovead" --version
unwritten "$fovead" --list-trackers --json
unwritten "$foveactl" stats
unwritten "$foveactl" stats --json
unwritten "$foveactl" watch --for 3600
unwritten "$foveactl" watch --for 1 --json
unwritten "$foveactl" snapshot full.png
unwritten "$foveactl" save full.exr
unwritten "$foveactl" move --by 0,0,0.1
unwritten "$foveactl" compare open.exr open.exr
unwritten "$foveactl" gaze info short.gaze
unwritten "$foveactl" gaze convert short.gaze full.gaze
# The picture is saved nevertheless. A pipe that nobody reads is handled in the same way.
unwritten "$fovead" $small --until 1spp --save unwritten.exr
"$programs/e2e_picture" unwritten.exr 256 128 >/dev/null
("$fovead" $small --until 1spp --save unread.exr 2>/dev/null || echo $? >status) | true
[ "$(cat status)" = 1 ] || fail 'a pipe that nobody reads was not an error'
"$programs/e2e_picture" unread.exr 256 128 >/dev/null

# For a client that watches, the orderly end of a daemon is not an error, but its death is. snapshot saves only whole
# pictures.
"$foveactl" watch --for 3600 >watch.txt 2>watch.err &
watcher=$!
await 'a client that watches' test -s watch.txt
stop
wait $watcher || fail "the daemon ended in order, but watch with status $?: $(cat watch.err)"
# The daemon counts a client as soon as it connects. If the daemon dies before it has welcomed the client, the client
# has no figures to print, and the test tries again.
tells_figures() {
    start $small --gaze synthetic:2
    "$foveactl" watch --for 3600 --json >watch.json 2>watch.err &
    watcher=$!
    await 'a client that watches' told stats.json clients 2
    kill -9 "$daemon"
    wait "$daemon" || true
    daemon=
    ! wait $watcher || fail 'the daemon was killed, but watch succeeded'
    [ "$(wc -l <watch.err)" = 1 ] && grep -q 'closed the connection\|broke' watch.err || fail "$(cat watch.err)"
    grep -q '"coverage"' watch.json
}
await 'the figures of a daemon that is killed' tells_figures

# false_daemon KIND: start a daemon that welcomes the next client and then misbehaves in this way.
false_daemon() {
    rm -f false.sock
    "$programs/e2e_false_daemon" "$place/false.sock" "$1" &
    false=$!
    await 'a false daemon' test -S false.sock
}
for kind in gone torn nonsense; do
    false_daemon $kind
    refused "unix:$place/false.sock" "$foveactl" --connect "unix:$place/false.sock" --wait watch --for 3600
    wait $false
    false_daemon $kind
    refused "unix:$place/false.sock" "$foveactl" --connect "unix:$place/false.sock" --wait snapshot false.png
    wait $false
done
for kind in silent partial; do
    false_daemon $kind
    refused 'of the picture is there' "$foveactl" --connect "unix:$place/false.sock" --wait snapshot false.png --within 0.5
    wait $false
done
[ ! -e false.png ] || fail 'an incomplete picture was saved'

# The camera moves all the time: the picture never rests, but the snapshot is taken.
start $small --gaze synthetic:2
while kill -0 "$daemon" && "$foveactl" move --by 0.001,0,0 && sleep 1; do :; done >moves 2>/dev/null &
mover=$!
"$foveactl" snapshot moved.png --settle 3 || fail 'no picture while the camera moves'
"$programs/e2e_picture" moved.png 256 128 >/dev/null
[ "$(wc -l <moves)" -gt 2 ] || fail "the camera did not move: $(cat moves)"
stop
wait $mover || true

# Signals that arrive together are one request to end. SIGHUP is such a request too, unless nohup ignores it. The
# picture is saved.
for signals in 'INT TERM' 'INT TERM HUP' HUP; do
    rm -f kept.exr
    start $small --gaze synthetic:2 --save kept.exr
    kill -STOP "$daemon" # so that all of them arrive at once
    for signal in $signals; do kill "-$signal" "$daemon"; done
    kill -CONT "$daemon"
    wait "$daemon" || fail "status $? after $signals"
    daemon=
    "$programs/e2e_picture" kept.exr 256 128 >/dev/null
done
rm daemon.out
(
    trap '' HUP
    exec "$fovead" $small --gaze synthetic:2 --save kept.exr >daemon.out 2>daemon.err
) &
daemon=$!
await 'the daemon' grep -qs '^fovead: ready$' daemon.out
kill -HUP "$daemon"
"$foveactl" stats >/dev/null || fail 'the daemon ends in spite of nohup'
stop
# A client that nohup started ignores it, too.
start $small --gaze synthetic:2
rm watch.txt
(
    trap '' HUP
    exec "$foveactl" watch --for 3600 >watch.txt 2>watch.err
) &
watcher=$!
await 'a client that watches' test -s watch.txt
[ "$((0x$(sed -n 's/^SigIgn:[^0-9a-f]*//p' /proc/$watcher/status) & 1))" = 1 ] || fail 'watch heeds SIGHUP in spite of nohup'
kill $watcher
wait $watcher || fail "watch ended with status $? after SIGTERM"
stop
# SIGHUP also ends a client that records.
start $small --gaze synthetic:2
"$foveactl" record hup.gaze --for 3600 >record.out &
recorder=$!
await 'a recording' test -s record.out
kill -HUP $recorder
wait $recorder || fail "record ended with status $? after SIGHUP"
grep -q '^recorded' record.out || fail "$(cat record.out)"
stop
