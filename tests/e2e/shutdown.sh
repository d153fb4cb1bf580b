#!/bin/sh
# Sockets and the end: whose they are, what is left behind, who may connect.
. "$(dirname "$0")/common.sh"
make_room
small="--scene room.obj --size 256x128 --gaze synthetic:2"

# The default socket is this user's alone, whatever the umask, and is gone afterwards.
(umask 0; exec "$fovead" $small --json --save end.exr >daemon.json 2>daemon.err) &
daemon=$!
"$foveactl" --wait stats >stats.txt
grep -q '^fovead: ready$' daemon.err || fail "not ready"
[ "$(stat -c %a fovead.sock)" = 600 ] || fail "the socket's mode is $(stat -c %a fovead.sock)"
refused "in use" "$fovead" $small
[ -S fovead.sock ] || fail "a second daemon has removed the first one's socket"
"$foveactl" stats >/dev/null || fail "the first daemon does not answer any more"
stop TERM
[ ! -e fovead.sock ] || fail "the socket is left behind"
[ "$(number paths daemon.json)" -gt 0 ] || fail "no paths"
grep -q '"saved": "end.exr"' daemon.json && [ -s end.exr ] || fail "not saved: $(cat daemon.json)"

# One that was killed leaves a socket, which the next one replaces; SIGINT ends as SIGTERM does.
start $small
kill -9 "$daemon"
wait "$daemon" || true
[ -S fovead.sock ] || fail "there is no stale socket to test with"
start $small
"$foveactl" stats >/dev/null
stop INT
[ ! -e fovead.sock ] && [ ! -e fovead.sock.lock ] || fail "the socket is left behind"

# What is not a socket is left alone.
echo precious >fovead.sock
refused fovead.sock "$fovead" $small
[ "$(cat fovead.sock)" = precious ] || fail "a file was removed"
rm fovead.sock

# A client stays, and a daemon that ends all the same ends cleanly; the client is told.
start $small
"$foveactl" watch --for 3600 >watch.txt &
watcher=$!
await 'a client that watches' test -s watch.txt
stop
wait "$watcher" || fail "watch ended with status $?"

# Other machines only with a token.
port=$("$programs/e2e_port")
refused FOVEAD_TOKEN "$fovead" $small --listen "tcp:0.0.0.0:$port"
FOVEAD_TOKEN=sesame "$fovead" $small --listen "tcp:0.0.0.0:$port" --listen "unix:$place/own" >daemon.out 2>daemon.err &
daemon=$!
"$foveactl" --wait --connect "unix:$place/own" stats >/dev/null || fail "a Unix socket needs no token"
refused token "$foveactl" --connect "tcp:127.0.0.1:$port" stats
FOVEAD_TOKEN=sesam refused token "$foveactl" --connect "tcp:127.0.0.1:$port" stats
FOVEAD_TOKEN=sesame "$foveactl" --connect "tcp:127.0.0.1:$port" stats >/dev/null || fail "the token does not open"
stop

# A service manager is told.
"$programs/e2e_notified" "$place/notify" "$fovead" $small >daemon.out 2>daemon.err || fail "no READY=1: $(cat daemon.err)"
