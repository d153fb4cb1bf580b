#!/bin/sh
# What a client can do over a Unix socket and over TCP: look, freeze, take pictures, and have the film saved.
. "$(dirname "$0")/common.sh"
make_room
make_log
tcp=tcp:localhost:$("$programs/e2e_port")
start --scene room.obj --size 1024x512 --gaze pointer --listen "unix:$place/fovead.sock" --listen "$tcp"

# A snapshot waits for the outline, so it is whole and not black.
"$foveactl" snapshot whole.png
"$foveactl" snapshot whole.exr --settle 0.2 --connect "$tcp"
"$foveactl" snapshot ahead.jpg --view -30,10,90 --size 200x100 --json >ahead.json
grep -q '"view_deg": \[' ahead.json || fail "$(cat ahead.json)"
"$foveactl" snapshot bright.png --exposure 3 --settle 0.2
"$foveactl" snapshot grey.png --exposure auto --settle 0.2
[ "$("$programs/e2e_picture" bright.png 1024 512)" -gt "$("$programs/e2e_picture" whole.png 1024 512)" ] ||
    fail "three stops do not make the picture brighter"
grey=$("$programs/e2e_picture" grey.png 1024 512)
[ "$grey" -gt 100 ] && [ "$grey" -lt 400 ] || fail "auto exposure gives a mean of $grey thousandths"
refused exposure "$foveactl" snapshot grey.png --exposure bright
refused gaze "$foveactl" snapshot gaze.png --view gaze,60
"$programs/e2e_picture" whole.png 1024 512 >/dev/null
"$programs/e2e_picture" whole.exr 1024 512 >/dev/null
"$programs/e2e_picture" ahead.jpg 200 100 >/dev/null

# The gaze goes where a client sends it, and the picture is finest there.
"$foveactl" look -90,0
looks_left() { grep -A 1 '"gaze_deg"' watch.json | grep -q -e '-\(90.0\|89.9\)'; }
has_tiles() { [ "$(number bytes_received watch.json)" -gt 10000 ]; }
has_latency() { [ "$(sed -n '/"latency"/,$p' watch.json | sed -n 's/.*"count": //p' | head -n 1 | tr -d ,)" -ge 1 ]; }
for what in looks_left has_tiles has_latency; do await "$what" watched watch.json $what; done
"$foveactl" snapshot gaze.png --view gaze,60 >view.txt
grep -q -e '-90.0 degrees right' view.txt || fail "$(cat view.txt)"

"$foveactl" freeze
"$foveactl" stats --json | grep -q '"frozen": true' || fail "not frozen"
"$foveactl" --connect "$tcp" unfreeze
"$foveactl" stats --json | grep -q '"frozen": false' || fail "still frozen"
"$foveactl" stats | grep -q 'mode fv' || fail "no table"

# Only clients of this user may have files written. Relative names are relative to the client's folder.
"$foveactl" save saved.exr | grep -qF "$place/saved.exr" || fail "the answer does not name the file"
"$programs/e2e_picture" saved.exr 1024 512 >/dev/null
refused socket "$foveactl" save tcp.exr --connect "$tcp"
[ ! -e tcp.exr ] || fail "a client over TCP had a file written"
refused no/such "$foveactl" save no/such/folder.exr
refused ".exr, .png or .jpg" "$foveactl" save saved.tif
mkdir taken.exr
refused taken.exr "$foveactl" save taken.exr

"$foveactl" samples saved.exr samples.png --gaze short.gaze
"$programs/e2e_picture" samples.png 1024 512 >/dev/null
refused samples "$foveactl" samples whole.exr samples.png
stop
[ "$(wc -l <daemon.err)" = 0 ] || fail "the daemon complains: $(cat daemon.err)"

# A recorded gaze does not follow a pointer, and the stream tells when it ends.
start --scene room.obj --size 256x128 --gaze replay:short.gaze
refused replay "$foveactl" look 10,10
"$foveactl" watch --until-finished --json >watch.json || fail "watch does not end with the recording"
grep -q '"finished": true' watch.json || fail "$(cat watch.json)"
stop
