#!/bin/sh
# Clients that misbehave are dropped with a line that says why; the daemon and an honest client go on.
. "$(dirname "$0")/common.sh"
make_room
start --scene room.obj --size 1024x512 --gaze synthetic:1

"$foveactl" watch --for 12 --json >watch.json 2>watch.err &
watcher=$!
kinds="noise huge over zero half silent early serial welcome view view-corner view-area view-far recentre nowhere nan far flat version encoding"
clients=
for kind in $kinds deaf flood; do
    "$programs/e2e_hostile" "$place/fovead.sock" "$kind" 2>"$kind.err" &
    clients="$clients $!"
done
for client in $clients; do wait "$client" || fail "a hostile client was not treated right: $(cat ./*.err)"; done
kill -0 "$daemon" || fail "the daemon has gone"
wait "$watcher" || fail "the honest client: $(cat watch.err)"
# The coarse levels are 42 tiles: fine ones came too, or come to the next client.
is_served() { [ "$(number tiles_received watch.json)" -gt 60 ] && [ "$(number paths watch.json)" -gt 10000 ]; }
is_served || await 'tiles for an honest client' watched watch.json is_served
lines=$(grep -c '^fovead: client [0-9]* (process [0-9]*\(, hostile\)*) dropped: ' daemon.err)
[ "$lines" -ge 20 ] && [ "$lines" -le 21 ] || fail "$lines clients were dropped, of $kinds"
"$foveactl" stats >/dev/null
stop
