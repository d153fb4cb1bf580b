#!/bin/bash
# Crowds: 1,000 connections by HTTP and by raw sockets that come and go, then 50 clients, of which some read nothing or read
# slowly. The others are served, the daemon keeps nothing of those that have gone, and an honest client goes on through it all.
. "$(dirname "$0")/common.sh"
make_room
http=$("$programs/e2e_port")
tcp=$("$programs/e2e_port")
start --scene room.obj --size 1024x512 --gaze synthetic:1 --listen "http:127.0.0.1:$http" --listen "tcp:127.0.0.1:$tcp" --listen "unix:$place/fovead.sock"
"$foveactl" watch --for 100000 >watch.out 2>watch.err &
watcher=$!
is_watched() { told stats.json clients 2; }
await 'the honest client' is_watched

# descriptors: how many the daemon has. memory: what it has for itself, KiB.
descriptors() { find "/proc/$daemon/fd" -mindepth 1 | wc -l; }
memory() { sed -n 's/^RssAnon:[[:space:]]*\([0-9]*\) kB$/\1/p' "/proc/$daemon/status"; }
open=$(descriptors)
"$programs/e2e_crowd" come "$http" "$tcp" 200 || fail "connections that come and go: $(tail daemon.err)"
before=$(memory)
"$programs/e2e_crowd" come "$http" "$tcp" 1000 || fail "connections that come and go: $(tail daemon.err)"
are_gone() { "$foveactl" stats --json >stats.json && [ "$(number clients stats.json)" = 2 ] && [ "$(descriptors)" -le "$open" ]; }
await 'all of them to be gone' are_gone
after=$(memory)
echo "memory: $before KiB, then $after KiB"
# A connection has a list of all tiles, so if one in five were kept, that would be 8 MiB. Sanitizers keep what was freed.
grep -q '^SANITIZE:STRING=..*' "$programs/CMakeCache.txt" || [ $((after - before)) -lt 8000 ] || fail 'the daemon keeps memory'

"$programs/e2e_crowd" stay "$http" "$tcp" || fail "clients that stay: $(tail daemon.err)"
await 'all of them to be gone' are_gone
kill -0 "$watcher" || fail "the honest client: $(cat watch.err)"
kill "$watcher"
stop
! grep -v '^fovead: client [0-9]* (.*) \(dropped\|turned away\): ' daemon.err || fail 'other lines'
