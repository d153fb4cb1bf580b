# Programs among fake eye trackers: sh umockdev.sh PROGRAMS SOURCE WHAT, where PROGRAMS is the build directory and WHAT one
# of the names at the end. Exit code 77: umockdev is missing.
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
# The preload comes before a sanitizer's library, and is not ours to be checked for leaks.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}verify_asan_link_order=0:detect_leaks=0"

fail() {
    printf 'FAIL: %s\n' "$*" >&2
    exit 1
}

# run ACTION... -- COMMAND...: what it prints is kept in out and shown; it must end well.
run() {
    status=0
    ${wrapper-umockdev-wrapper} "$plug" "$@" >out 2>err || status=$?
    cat out
    sed '/uevent_sender_send: No such device/d; s/^/  /' err
    [ "$status" = 0 ] || fail "exit code $status: plug $*"
}

# value NAME: what the probe said of it.
value() { sed -n "s/.*\\<$1=\\([0-9.]*\\).*/\\1/p" out; }
at_least() { [ "$(value "$1" | cut -d. -f1)" -ge "$2" ] || fail "$1=$(value "$1"), expected $2 or more"; }
is() { [ "$(value "$1")" = "$2" ] || fail "$1=$(value "$1"), expected $2"; }
says() { grep -q "$1" err || fail "nobody said '$1'"; }

case $what in
hid)
    # There, gone, there again; its loss is told, its screen is its own.
    run hid run wait:1 out:hid wait:0.5 hid wait:1 end -- "$probe" hid 30
    at_least valid 300
    is losses 1
    is connections 2
    is gaps 0
    says 'plug: hid: started 1, stopped 1' # by the program, when it ends
    says 'screen of 600 x 340 mm (calibrated)'
    # Plugged in later; then one that sends garbage, which is survived, and the good one again.
    run run wait:0.3 hid wait:1.5 out:hid wait:0.2 garbage wait:0.5 out:garbage wait:0.2 hid wait:1 end -- "$probe" hid 30
    at_least valid 300
    is connections 3
    # One whose descriptor is cut off is refused in one line, and stands in nobody's way.
    status=0
    umockdev-wrapper "$plug" broken -- "$probe" hid 1 >out 2>err || status=$?
    grep -q 'FAIL: /dev/hidraw0 (Fovea Test Tracker): report descriptor, byte 38' out || fail "$(cat out)"
    run broken hid run wait:1 end -- "$probe" hid 30
    at_least valid 200
    # What it reports of its status between reports of gaze is told, and that it no longer is so.
    run unready run wait:2 end -- "$probe" hid 30
    at_least valid 500
    is gaps 0
    says '500 Hz; it asks for the user to be calibrated'
    tail -n 2 err | grep -q '500 Hz \[heap' || fail "it is ready, and nobody says so: $(cat err)"
    # A tracker that is slower, at a rate of its own.
    run hid:60 run wait:2 end -- "$probe" hid 30
    at_least valid 80
    ;;
psvr2)
    run psvr2 run wait:1 out:psvr2 wait:0.5 psvr2 wait:1 end -- "$probe" psvr2 30
    at_least valid 300
    is losses 1
    is connections 2
    says 'PlayStation VR2 on /dev/bus/usb/001/002'
    run run wait:0.3 psvr2 wait:2 end -- "$probe" psvr2 30
    at_least valid 200
    # A user's calibration goes to the device, whole; one that is not there is an error.
    head -c 5000 /dev/zero >calibration
    run psvr2 run wait:0.5 end -- "$probe" psvr2 30 none calibration
    says 'plug: psvr2: started 1, stopped 1, calibration of 5000 bytes'
    says 'calibrated from a file'
    status=0
    umockdev-wrapper "$plug" psvr2 -- "$probe" psvr2 1 none absent >out 2>err || status=$?
    grep -q 'FAIL: absent: No such file' out || fail "$(cat out)"
    # What comes back while it is closed, and what does not come back, is left behind: it can be opened again.
    run psvr2-late -- "$programs/device_reopen" psvr2 5
    run psvr2-stuck -- "$programs/device_reopen" psvr2 2
    ;;
auto)
    # A recording until a tracker comes; and no way back when it goes.
    run run wait:1 hid wait:2 out:hid wait:0.5 psvr2 wait:1 end -- "$probe" auto 30 "$source/fixtures/hall.gaze"
    says 'hall.gaze.*no eye tracker found'
    says 'eye tracker Fovea Test Tracker'
    says 'eye tracker PlayStation VR2'
    at_least valid 300
    is connections 2
    # Two at once: the first of the table; when it goes, the other.
    run psvr2 hid run wait:1 out:hid wait:1 end -- "$probe" auto 30
    says 'eye tracker Fovea Test Tracker'
    says 'eye tracker PlayStation VR2'
    is connections 2
    ;;
list)
    # What is there, what it can do, and, without the right to it, the way out.
    run hid broken psvr2 -- "$programs/fovead" --list-trackers
    grep -q 'Fovea Test Tracker (deed:feed)' out || fail 'no HID tracker in the list'
    grep -q 'gaze hid:/dev/hidraw0$' out || fail 'its path is not told'
    grep -q 'problem.*byte 38: an item that is cut short' out || fail 'the broken one has no problem'
    grep -q 'PlayStation VR2 (054c:0cde)' out || fail 'no PlayStation VR2 in the list'
    if [ "$(id -u)" = 0 ] && setpriv --reuid 65534 --regid 65534 --clear-groups test -x "$programs/fovead" 2>/dev/null; then
        chmod 755 "$place"
        # libusb wants to write in the bed, for uevents; the devices themselves stay root's.
        run hid psvr2 -- sh -c 'chmod -R a+rwX "$UMOCKDEV_DIR"; exec setpriv --reuid 65534 --regid 65534 --clear-groups "$@"' \
            sh "$programs/fovead" --list-trackers
        for tracker in 'Permission denied.*deed:feed' 'PlayStation VR2): Access denied'; do
            grep 'problem.*install 70-fovead.rules' out | grep -q "$tracker" || fail "no advice on permissions: $tracker"
        done
    fi
    # What it advises is installed where udev looks, before the rule that grants access, and has these trackers.
    DESTDIR="$place/root" cmake --install "$programs" >/dev/null
    rules=$(find root -path '*/lib/udev/rules.d/*.rules')
    [ "$(printf '%s\n' "${rules##*/}" 73-seat-late.rules | sort | head -n 1)" = 70-fovead.rules ] || fail "rules: $rules"
    for line in '^SUBSYSTEM=="usb".*"054c".*"0cde".*uaccess' '^KERNEL=="hidraw\*".*"deed".*"feed".*uaccess'; do
        grep -q "$line" "$rules" || fail "no $line in $rules"
    done
    ;;
conformance)
    # Sources that deliver, by the suite that is for all of them.
    run hid psvr2 -- "$programs/test_tracker_conformance" hid psvr2
    ;;
fovead)
    # The daemon itself, unmodified, while it renders.
    make_room
    for spec in hid auto psvr2; do
        kind=hid
        [ "$spec" = psvr2 ] && kind=psvr2
        run $kind run wait:1.5 out:$kind wait:0.5 $kind -- "$programs/fovead" --scene room.obj --size 256 --gaze $spec \
            --until 4s --json
        samples=$(sed -n 's/.*"gaze_valid": \([0-9]*\).*/\1/p' out)
        [ "$samples" -ge 300 ] || fail "fovead --gaze $spec saw $samples samples"
    done
    run run wait:1 hid -- "$programs/fovead" --scene room.obj --size 256 --gaze hid --until 4s --json
    samples=$(sed -n 's/.*"gaze_valid": \([0-9]*\).*/\1/p' out)
    [ "$samples" -ge 200 ] || fail "fovead saw $samples samples of a tracker that came later"
    run garbage -- "$programs/fovead" --scene room.obj --size 256 --gaze auto --until 2s --json
    ;;
leak)
    # 12 times in and out, or as often as CYCLES says: no plugging is missed, descriptors and threads are as before, and
    # from the middle to the end the heap has not grown by more than allocators keep for themselves.
    # Without the wrapper there are no uevents, which fovead does not go by, and of which umockdev aborts when a program
    # closes its socket for them in the same moment: once in some hundred times.
    cycles=${CYCLES:-12} wrapper=
    for kind in ${KINDS:-hid psvr2}; do
        run "$kind" run repeat:"$cycles" wait:0.6 out:"$kind" wait:0.05 "$kind" limit:10 end -- "$probe" "$kind" "$((cycles * 3 + 10))"
        at_least connections "$cycles"
        at_least losses $((cycles * 9 / 10)) # gone before its first report: nothing to lose
        set -- $(sed 's/.*descriptors=\([0-9]*\)->\([0-9]*\) threads=\([0-9]*\)->\([0-9]*\).*/\1 \2 \3 \4/' out)
        [ "$2" -le "$1" ] || fail "$(($2 - $1)) descriptors leaked"
        [ "$4" -le "$3" ] || fail "$(($4 - $3)) threads leaked"
        sed -n 's/^probe: eye tracker.*\[heap \([0-9]*\)\]$/\1/p' err >heap
        grown=$(($(tail -n 1 heap) - $(sed -n "$((cycles / 2))p" heap)))
        [ "$grown" -le $((8192 + 8 * cycles)) ] || fail "$grown bytes leaked in $((cycles / 2)) cycles"
        echo "$kind: $cycles cycles; heap grew by $grown bytes in the second half"
    done
    ;;
latency)
    # That it works; the bar is for a machine that does nothing else: device_latency prints it.
    make_room
    umockdev-wrapper "$programs/device_latency" room.obj 3 500 >out 2>err || [ $? = 1 ] || fail "$(cat err)"
    cat out
    grep -q 'sent to batch' out || fail 'no figures'
    ;;
*)
    fail "unknown test $what"
    ;;
esac
