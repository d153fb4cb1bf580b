#!/bin/sh
# Programs that are killed during a save, a recording or a snapshot: no file is left half written, no part of a file is
# left after the next start, a log has all samples that were reported as recorded, and the picture is saved if the signal
# can be caught. kills.sh PROGRAMS SOURCE [COUNT [SEED]]: so many kills of each kind.
# If this test runs under nohup, its programs should not.
[ -n "${DEFAULT_SIGNALS-}" ] || DEFAULT_SIGNALS=1 exec env --default-signal=HUP sh "$0" "$@"
. "$(dirname "$0")/common.sh"
count=${3:-2}
seed=${4:-1}
make_room
small="--scene room.obj --size 512x256 --gaze synthetic:7 --save end.exr --record log.gaze --replace"
"$fovead" --scene room.obj --size 512x256 --until 1spp --save old.exr >/dev/null 2>&1

# pause MOST_MS: a random time up to that, from the seed.
pauses=0
pause() {
    pauses=$((pauses + 1))
    sleep "$(awk -v seed="$((seed * 1000003 + pauses))" -v most="$1" 'BEGIN {srand(seed); printf "%.4f", rand() * most / 1000}')"
}

# hit PROCESS KIND: one of the kinds of signals.
hit() {
    case $2 in
    TWICE) kill -TERM "$1" "$1" 2>/dev/null || true ;;
    *) kill "-$2" "$1" ;;
    esac
}

# The program that was hit has ended as it should: of KILL at once, of all else in order.
ended() {
    status=0
    wait "$1" || status=$?
    case $2 in
    KILL) [ "$status" = 137 ] || fail "status $status after SIGKILL" ;;
    *) [ "$status" = 0 ] || fail "status $status after $2: $(cat daemon.err)" ;;
    esac
}

# Every pixel can be read: one that was saved early may be black.
is_whole() { "$programs/e2e_mean" "$1" >/dev/null || fail "half a picture: $1, $2"; }
no_parts() {
    parts=$(find . -name '*.part*')
    [ -z "$parts" ] || fail "left behind, $1: $parts"
}

most_lost=0
# The log has what stats said, and nothing torn in the middle.
keeps_log() {
    "$foveactl" gaze info --json log.gaze >info.json 2>info.err || fail "no log, $1: $(cat info.err)"
    kept=$(number samples info.json)
    [ "$kept" -ge "$(number recorded before.json)" ] || fail "$kept samples are kept, $1, and stats said: $(cat before.json)"
    lost=$(($(number gaze_samples before.json) - kept))
    [ "$lost" -le "$most_lost" ] || most_lost=$lost
}

kills=0
for signal in KILL TERM TWICE HUP; do
    for i in $(seq "$count"); do
        # While a client has the film saved, and gaze is recorded all the time.
        cp old.exr end.exr
        [ $((i % 2)) = 0 ] && cp old.exr pic.exr || rm -f pic.exr
        start $small
        no_parts "after the next start ($signal $i)"
        await 'ten samples' told before.json recorded 10
        pause 300
        "$foveactl" stats --json >before.json
        "$foveactl" save pic.exr >save.out 2>save.err &
        saver=$!
        pause 120
        hit "$daemon" $signal
        wait $saver && saved=true || saved=false
        ended "$daemon" $signal
        daemon=
        [ ! -e pic.exr ] || is_whole pic.exr "$signal $i"
        ! $saved || [ -e pic.exr ] || fail "a success that left nothing ($signal $i): $(cat save.out)"
        [ $((i % 2)) = 1 ] || [ -e pic.exr ] || fail "the old picture has gone ($signal $i)"
        is_whole end.exr "$signal $i"
        [ $signal = KILL ] || ! cmp -s old.exr end.exr || fail "the picture of the end is not kept ($signal $i)"
        keeps_log "$signal $i"

        # While the film of the end is saved: when the render is done. Only a kill stops that.
        rm daemon.out
        cp old.exr end.exr
        "$fovead" --scene room.obj --size 512x256 --until 0.3s --save end.exr >daemon.out 2>daemon.err &
        daemon=$!
        await 'the render to begin' grep -qs ready daemon.out
        pause 500
        ! kill -0 "$daemon" 2>/dev/null || hit "$daemon" $signal
        status=0
        wait "$daemon" || status=$?
        daemon=
        [ "$status" = 0 ] || [ $signal = KILL ] || fail "status $status after $signal: $(cat daemon.err)"
        is_whole end.exr "$signal $i"
        [ "$status" != 0 ] || ! cmp -s old.exr end.exr || fail "a success that left the old picture ($signal $i)"

        # While a client writes a snapshot.
        cp old.exr snap.exr
        start $small
        no_parts "after the next start ($signal $i)"
        "$foveactl" snapshot snap.exr --settle 0 >snap.out 2>snap.err &
        snapshot=$!
        pause 600
        ! kill -0 $snapshot 2>/dev/null || hit $snapshot $signal
        wait $snapshot && snapped=true || snapped=false
        is_whole snap.exr "$signal $i"
        ! $snapped || ! cmp -s old.exr snap.exr || fail "a snapshot that left the old one ($signal $i)"
        "$foveactl" snapshot snap.exr --settle 0 >/dev/null
        no_parts "after the next snapshot ($signal $i)"
        stop
        kills=$((kills + 3))
    done
done
echo "$kills kills, $count of each signal in each place; at most $most_lost samples (of 120 a second) came before the last stats and are not kept"
