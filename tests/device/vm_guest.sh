# The part of vm.sh that runs in the guest: sh vm_guest.sh PROGRAMS. Trackers are devices of the guest's kernel, and
# programs are those in PROGRAMS.
programs=$1
. "$(dirname "$0")/../room.sh"
cd /run
export HOME=/run XDG_RUNTIME_DIR=/run TMPDIR=/run
failed=0

fail() {
    echo "FAIL: $*"
    failed=1
}

seconds() { echo "  at $(cut -d' ' -f1 /proc/uptime) s"; }

# probe SPEC: read a gaze source in the background. judge SAMPLES CONNECTIONS: end the probe, and check that it saw at
# least this many.
probe() { "$programs/device_probe" "$1" >probe.out 2>probe.err & probe=$!; }
judge() {
    kill "$probe" 2>/dev/null
    wait "$probe"
    cat probe.out probe.err
    valid=$(sed -n 's/.* valid=\([0-9]*\) .*/\1/p' probe.out)
    connections=$(sed -n 's/.* connections=\([0-9]*\) .*/\1/p' probe.out)
    [ "${valid:-0}" -ge "$1" ] || fail "${valid:-no} samples, expected $1 or more"
    [ "${connections:-0}" -ge "$2" ] || fail "${connections:-no} connections, expected $2 or more"
    ! grep -q FAIL probe.out || fail "$(cat probe.out)"
    seconds
}

echo "== HID through uhid and hidraw: unplugged in the middle, and plugged in again"
probe hid
"$programs/vm_hid" 1000 500 || fail "the tracker could not be made"
"$programs/vm_hid" 1000 500 || fail "the tracker could not be made again"
judge 200 2

echo "== PlayStation VR2 through vhci_hcd and usbfs: the same"
probe psvr2
"$programs/vm_usb" 1000 500 || fail "the PlayStation VR2 could not be attached"
"$programs/vm_usb" 1000 500 || fail "the PlayStation VR2 could not be attached again"
judge 200 2

echo "== fovead itself, both trackers at once; the one that it took is pulled out, and the other goes on"
make_room
"$programs/fovead" --scene room.obj --size 128 --gaze auto --json >fovead.out 2>fovead.err & fovead=$!
# fovead says which tracker it takes only when it is ready.
while ! grep -q '^fovead: ready$' fovead.err && kill -0 "$fovead" 2>/dev/null; do sleep 0.1; done
"$programs/vm_hid" 750 250 & hid=$!
"$programs/vm_usb" 750 250 & usb=$!
# If fovead ends early, nobody opens the trackers: end them too.
(tail --pid="$fovead" -f /dev/null; kill "$hid" "$usb" 2>/dev/null) & watcher=$!
wait "$hid" || fail "fovead never opened the HID tracker"
wait "$usb" || fail "fovead never asked the PlayStation VR2 for gaze"
kill "$watcher" "$fovead"
wait "$fovead" || {
    fail "fovead ended with $?"
    cat fovead.err
}
grep gaze fovead.out
for name in 'Fovea Test Tracker' 'PlayStation VR2'; do
    grep -q "eye tracker $name" fovead.err || fail "fovead never took the $name: $(cat fovead.err)"
done
valid=$(sed -n 's/.*"gaze_valid": \([0-9]*\).*/\1/p' fovead.out)
[ "${valid:-0}" -ge 100 ] || fail "fovead saw ${valid:-no} valid samples"
seconds
exit $failed
