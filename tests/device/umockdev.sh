# Tests of programs among fake eye trackers: sh umockdev.sh PROGRAMS SOURCE WHAT, where PROGRAMS is the build directory
# and WHAT is one of the names in the `case` below. Exit code 77: umockdev is missing.
set -eu
. "$(dirname "$0")/../room.sh"
programs=$(cd "$1" && pwd)
source=$(cd "$2" && pwd)
what=$3
plug=$programs/device_plug
probe=$programs/device_probe
if ! [ -x "$plug" ] || ! command -v umockdev-wrapper >/dev/null; then
    echo "skipped: umockdev is not installed (sh daemon/setup.sh tests)"
    exit 77
fi
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place"
# umockdev's preload comes before a sanitizer's library, and its leaks are not ours to check.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0:detect_leaks=0"

fail() {
    printf 'FAIL: %s\n' "$*" >&2
    exit 1
}

# run ACTION... -- COMMAND...: run the command under plug, keep what it prints in the files out and err, show it, and
# fail unless the exit code is 0.
run() {
    status=0
    ${wrapper-umockdev-wrapper} "$plug" "$@" >out 2>err || status=$?
    cat out
    sed '/uevent_sender_send: No such device/d; s/^/  /' err
    [ "$status" = 0 ] || fail "exit code $status: plug $*"
}

# value NAME: a value in the probe's summary.
value() { sed -n "s/.*\\<$1=\\([0-9.]*\\).*/\\1/p" out; }
at_least() { [ "$(value "$1" | cut -d. -f1)" -ge "$2" ] || fail "$1=$(value "$1"), expected $2 or more"; }
is() { [ "$(value "$1")" = "$2" ] || fail "$1=$(value "$1"), expected $2"; }
says() { grep -q "$1" err || fail "stderr does not contain '$1'"; }

# Fail if a sample is missing. When the reader is more than a second late, the source may drop samples: it keeps those
# of about two seconds.
gapless() { [ "$(value gaps)" = 0 ] || [ "$(value worst_wait_ms | cut -d. -f1)" -ge 1000 ] || fail "gaps: $(cat out)"; }

case $what in
hid)
    # A tracker is there, goes, and comes back: the loss is reported, and the screen is the tracker's own.
    run hid run taken:200 out:hid hid taken:200 end -- "$probe" hid
    at_least valid 300
    at_least losses 1
    is connections 2
    gapless
    says 'plug: hid: started 1, stopped 1' # by the program, when it ends
    says 'screen of 600 x 340 mm (calibrated)'
    # A tracker is plugged in later; then one that sends garbage, which does no harm; then the good one again.
    run run said:'waiting for an eye tracker' hid taken:200 out:hid garbage taken:100 out:garbage hid taken:200 end -- "$probe" hid
    at_least valid 300
    is connections 3
    # A tracker whose descriptor is cut off is refused with one line, and does not keep another one from being used.
    status=0
    umockdev-wrapper "$plug" broken -- "$probe" hid >out 2>err || status=$?
    grep -q 'FAIL: /dev/hidraw0 (Fovea Test Tracker): report descriptor, byte 38' out || fail "$(cat out)"
    run broken hid run taken:250 end -- "$probe" hid
    at_least valid 200
    # A status that the tracker reports between gaze reports is shown, and disappears when it is over.
    run unready run said:'500 Hz; it asks for the user to be calibrated' ok taken:+300 end -- "$probe" hid
    at_least valid 500
    gapless
    tail -n 2 err | grep -q '500 Hz \[heap' || fail "the tracker is ready, but its status does not say so: $(cat err)"
    # A slower tracker runs at its own rate.
    run hid:60 run taken:100 end -- "$probe" hid
    at_least valid 80
    ;;
psvr2)
    run psvr2 run taken:200 out:psvr2 psvr2 taken:200 end -- "$probe" psvr2
    at_least valid 300
    at_least losses 1
    is connections 2
    says 'PlayStation VR2 on /dev/bus/usb/001/002'
    run run said:'waiting for an eye tracker' psvr2 taken:250 end -- "$probe" psvr2
    at_least valid 200
    # The user's calibration is sent to the device as a whole. A missing file is an error.
    head -c 5000 /dev/zero >calibration
    run psvr2 run taken:50 end -- "$probe" psvr2 none calibration
    says 'plug: psvr2: started 1, stopped 1, calibration of 5000 bytes'
    says 'calibrated from a file'
    status=0
    umockdev-wrapper "$plug" psvr2 -- "$probe" psvr2 none absent >out 2>err || status=$?
    grep -q 'FAIL: absent: No such file' out || fail "$(cat out)"
    # Reads that return late or never while the device is closed are abandoned: the device can be opened again.
    run psvr2-late -- "$programs/device_reopen" psvr2 5
    run psvr2-stuck -- "$programs/device_reopen" psvr2 2
    ;;
auto)
    # A recording is replayed until a tracker comes. The source does not go back to it when the tracker goes.
    run run said:'no eye tracker found' hid said:'eye tracker Fovea Test Tracker' taken:200 out:hid \
        psvr2 said:'eye tracker PlayStation VR2' taken:200 end -- "$probe" auto "$source/fixtures/hall.gaze"
    says 'hall.gaze.*no eye tracker found'
    at_least valid 300
    is connections 2
    # Two trackers are there: the source takes the first of the table, and when that goes, the other.
    run psvr2 hid run said:'eye tracker Fovea Test Tracker' out:hid said:'eye tracker PlayStation VR2' end -- "$probe" auto
    is connections 2
    ;;
list)
    # The list shows the trackers, what they can do, and, if the user lacks permission, what to do about it.
    run hid broken psvr2 -- "$programs/fovead" --list-trackers
    grep -q 'Fovea Test Tracker (deed:feed)' out || fail 'no HID tracker in the list'
    grep -q 'gaze hid:/dev/hidraw0$' out || fail 'the list does not show its path'
    grep -q 'problem.*byte 38: an item that is cut short' out || fail 'the list shows no problem of the broken tracker'
    grep -q 'PlayStation VR2 (054c:0cde)' out || fail 'no PlayStation VR2 in the list'
    if [ "$(id -u)" = 0 ] && setpriv --reuid 65534 --regid 65534 --clear-groups test -x "$programs/fovead" 2>/dev/null; then
        chmod 755 "$place"
        # libusb writes uevents into the bed. The devices themselves still belong to root.
        run hid psvr2 -- sh -c 'chmod -R a+rwX "$UMOCKDEV_DIR"; exec setpriv --reuid 65534 --regid 65534 --clear-groups "$@"' \
            sh "$programs/fovead" --list-trackers
        for tracker in 'Permission denied.*deed:feed' 'PlayStation VR2): Access denied'; do
            grep 'problem.*install 70-fovead.rules' out | grep -q "$tracker" || fail "no advice on permissions: $tracker"
        done
    fi
    # The udev rules that the list recommends are installed where udev looks, before the rule that grants access, and
    # name these trackers.
    DESTDIR="$place/root" cmake --install "$programs" >/dev/null
    rules=$(find root -path '*/lib/udev/rules.d/*.rules')
    [ "$(printf '%s\n' "${rules##*/}" 73-seat-late.rules | sort | head -n 1)" = 70-fovead.rules ] || fail "rules: $rules"
    for line in '^SUBSYSTEM=="usb".*"054c".*"0cde".*uaccess' '^KERNEL=="hidraw\*".*"deed".*"feed".*uaccess'; do
        grep -q "$line" "$rules" || fail "no $line in $rules"
    done
    ;;
conformance)
    # Sources that deliver pass the test suite for all sources.
    run hid psvr2 -- "$programs/test_tracker_conformance" hid psvr2
    ;;
fovead)
    # The daemon itself, unmodified and rendering: gaze arrives, and arrives again after the tracker was unplugged.
    make_room
    cat >watched.sh <<'END'
set -eu
programs=$1 spec=$2 connections=$3
fail() { echo "$*" >&2; exit 1; }
. "$4/tests/room.sh"
"$programs/fovead" --scene room.obj --size 256 --gaze "$spec" --json &
daemon=$!
number() { sed -n "s/.*\"$1\": \([0-9]*\).*/\1/p" stats.json; }
stats() { kill -0 $daemon || fail 'the daemon has gone'; "$programs/foveactl" --wait stats --json >stats.json; }
sees() { stats && [ "$(number gaze_valid)" -ge "$1" ]; }
is_connected() { stats && [ "$(number connections)" = "$1" ]; }
for connection in $(seq "$connections"); do
    await "connection $connection" is_connected "$connection"
    await "gaze by connection $connection" sees $(($(number gaze_valid) + 100))
    touch "seen-$connection"
done
kill $daemon
wait $daemon
END
    export XDG_RUNTIME_DIR="$place"
    watched="sh watched.sh $programs"
    for spec in hid auto psvr2; do
        kind=hid
        [ "$spec" = psvr2 ] && kind=psvr2
        rm -f seen-*
        run $kind run file:seen-1 out:$kind $kind -- $watched $spec 2 "$source"
    done
    run run said:'fovead: ready' hid -- $watched hid 1 "$source"
    run garbage -- "$programs/fovead" --scene room.obj --size 256 --gaze auto --until 2s --json
    ;;
views)
    # Gaze of a tracker on a desk goes through the view; that of a headset's tracker turns with the headset that steers,
    # and is recorded with its pose.
    make_room
    cat >viewed.sh <<'END'
set -eu
programs=$1 spec=$2 kind=$3 from=$4 to=$5
fail() { echo "$*" >&2; exit 1; }
. "$6/tests/room.sh"
"$programs/fovead" --scene room.obj --size 256 --gaze "$spec" &
daemon=$!
aims() {
    kill -0 $daemon || fail 'the daemon has gone'
    "$programs/foveactl" --wait watch --for 0.5 --json >watch.json
    grep -A 1 '"gaze_deg"' watch.json | tail -n 1 | awk -v from="$1" -v to="$2" '{exit !($1 + 0 > from && $1 + 0 < to)}'
}
await 'an aim without a view' aims "$from" "$to"
mkfifo shown
"$programs/e2e_viewer" "unix:$XDG_RUNTIME_DIR/fovead.sock" "$kind" 90 <shown >viewer.out &
viewer=$!
exec 7>shown
await 'an aim in the view' aims $((from + 90)) $((to + 90))
"$programs/foveactl" record kept.gaze --for 0.5
exec 7>&-
wait $viewer
await 'an aim without the view' aims "$from" "$to"
kill $daemon
wait $daemon
END
    export XDG_RUNTIME_DIR="$place"
    has_bit() { awk -v bit="$1" 'NR > 2 && int($4 / bit) % 2 {found++} END {exit !found}' kept.gaze || fail "$2"; }
    run psvr2 -- sh viewed.sh "$programs" psvr2 headset 36 38 "$source"
    has_bit 4 "recorded without the headset's pose"
    rm shown kept.gaze
    run hid -- sh viewed.sh "$programs" hid window -20 20 "$source"
    has_bit 8 'recorded without points on the screen'
    ;;
leak)
    # Plug in and out 12 times, or as often as CYCLES says. No plugging is missed, descriptors and threads are as
    # before, and from the middle to the end the heap does not grow by more than allocators keep for themselves.
    # The wrapper is left out, so there are no uevents. fovead does not need them, and umockdev aborts if a program
    # closes its uevent socket at the wrong moment, which happens about once in a hundred times.
    cycles=${CYCLES:-12} wrapper=
    for kind in ${KINDS:-hid psvr2}; do
        run "$kind" run repeat:"$cycles" taken:50 out:"$kind" "$kind" end -- "$probe" "$kind"
        at_least connections "$cycles"
        at_least losses $((cycles * 9 / 10)) # none if it goes before its first report
        set -- $(sed 's/.*descriptors=\([0-9]*\)->\([0-9]*\) threads=\([0-9]*\)->\([0-9]*\).*/\1 \2 \3 \4/' out)
        [ "$2" -le "$1" ] || fail "$(($2 - $1)) descriptors leaked"
        [ "$4" -le "$3" ] || fail "$(($4 - $3)) threads leaked"
        sed -n 's/^probe: eye tracker.*\[heap \([0-9]*\)\]$/\1/p' err >heap
        half=$((($(wc -l <heap) + 1) / 2))
        grown=$(($(tail -n 1 heap) - $(sed -n "${half}p" heap)))
        [ "$grown" -le $((8192 + 8 * cycles)) ] || fail "$grown bytes leaked in $half cycles"
        echo "$kind: $cycles cycles; heap grew by $grown bytes in the second half"
    done
    ;;
latency)
    # Only checks that device_latency works: its bar is for a machine that does nothing else.
    make_room
    umockdev-wrapper "$programs/device_latency" room.obj 1500 500 >out 2>err || [ $? = 1 ] || fail "$(cat err)"
    cat out
    grep -q 'sent to batch' out || fail 'no figures'
    ;;
*)
    fail "unknown test $what"
    ;;
esac
