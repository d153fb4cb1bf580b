#!/bin/sh
# Sockets when a daemon ends: who owns them, what is left of them, and who may connect.
. "$(dirname "$0")/common.sh"
make_room
small="--scene room.obj --size 256x128 --gaze synthetic:2"

# The default socket is only for this user, whatever the umask, and is removed at the end.
(umask 0; exec "$fovead" $small --json --save end.exr >daemon.json 2>daemon.err) &
daemon=$!
"$foveactl" --wait stats >stats.txt
grep -q '^fovead: ready$' daemon.err || fail "the daemon does not say that it is ready"
[ "$(stat -c %a fovead.sock)" = 600 ] || fail "the socket's mode is $(stat -c %a fovead.sock)"
refused "in use" "$fovead" $small
[ -S fovead.sock ] || fail "a second daemon has removed the first one's socket"
"$foveactl" stats >/dev/null || fail "the first daemon does not answer any more"
stop TERM
[ ! -e fovead.sock ] || fail "the socket is left behind"
[ "$(number paths daemon.json)" -gt 0 ] || fail "no paths"
grep -q '"saved": "end.exr"' daemon.json && [ -s end.exr ] || fail "not saved: $(cat daemon.json)"

# A daemon that was killed leaves its socket behind, and the next daemon replaces it. SIGINT ends a daemon like SIGTERM.
start $small
kill -9 "$daemon"
wait "$daemon" || true
[ -S fovead.sock ] || fail "there is no stale socket to test with"
start $small
"$foveactl" stats >/dev/null
stop INT
[ ! -e fovead.sock ] && [ ! -e fovead.sock.lock ] || fail "the socket is left behind"

# The picture is saved however the daemon is ended: by a signal to all processes of its group, as a terminal and GNU
# timeout send it, or by one to all processes that it has started, as systemd sends it. Those end with the daemon.
family() {
    echo "$1"
    for child in $(grep -ls "^PPid:[[:space:]]*$1\$" /proc/[0-9]*/status | cut -d / -f 3); do family "$child"; done
}
for way in timeout group-INT group-TERM group-HUP all-TERM; do
    rm -f end.exr daemon.out
    case $way in
    timeout) env --default-signal=HUP timeout 7200 "$fovead" $small --save end.exr >daemon.out 2>daemon.err & ;;
    *) env --default-signal=HUP setsid "$fovead" $small --save end.exr >daemon.out 2>daemon.err & ;;
    esac
    daemon=$!
    await "the daemon ($way)" is_ready $way
    all=$(family "$daemon")
    images=
    for one in $all; do
        [ "$(readlink "/proc/$one/exe")" != "$programs/fovead-image" ] || images="$images $one"
    done
    [ -n "$images" ] || fail "no fovead-image among $all"
    case $way in
    timeout) kill -TERM "$daemon" ;;
    group-*) kill -s "${way#group-}" -- "-$daemon" ;;
    all-*) kill "-${way#all-}" $images "$daemon" ;;
    esac
    status=0
    wait "$daemon" || status=$?
    [ "$status" = 0 ] || fail "status $status ($way): $(cat daemon.err)"
    daemon=
    "$programs/e2e_mean" end.exr >/dev/null || fail "no picture ($way)"
    for one in $images; do
        [ "$(readlink "/proc/$one/exe")" != "$programs/fovead-image" ] || fail "fovead-image is left behind ($way)"
    done
done

# A file that is not a socket is left alone.
echo precious >fovead.sock
refused fovead.sock "$fovead" $small
[ "$(cat fovead.sock)" = precious ] || fail "a file was removed"
rm fovead.sock

# A daemon ends cleanly even if a client stays connected, and tells the client.
start $small
"$foveactl" watch --for 3600 >watch.txt &
watcher=$!
await 'a client that watches' test -s watch.txt
stop
wait "$watcher" || fail "watch ended with status $?"

# Other machines need a token.
port=$("$programs/e2e_port")
refused FOVEAD_TOKEN "$fovead" $small --listen "tcp:0.0.0.0:$port"
FOVEAD_TOKEN=sesame "$fovead" $small --listen "tcp:0.0.0.0:$port" --listen "unix:$place/own" >daemon.out 2>daemon.err &
daemon=$!
"$foveactl" --wait --connect "unix:$place/own" stats >/dev/null || fail "a Unix socket needs no token"
refused token "$foveactl" --connect "tcp:127.0.0.1:$port" stats
FOVEAD_TOKEN=sesam refused token "$foveactl" --connect "tcp:127.0.0.1:$port" stats
FOVEAD_TOKEN=sesame "$foveactl" --connect "tcp:127.0.0.1:$port" stats >/dev/null || fail "the right token is refused"
stop

# A service manager is notified.
"$programs/e2e_notified" "$place/notify" "$fovead" $small >daemon.out 2>daemon.err || fail "no READY=1: $(cat daemon.err)"
