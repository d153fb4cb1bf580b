#!/bin/sh
# The eye moves and the scene is edited while it is watched: each begins a new generation of the picture, and nothing of
# the old one is left in it.
. "$(dirname "$0")/common.sh"
make_room
mkdir pictures
cp "$source/fixtures/textures/rug.jpg" pictures/rug.jpg
cp "$source/fixtures/sky.hdr" sky.hdr
mode="--size 256x128 --mode od --gaze pointer"

# generation: of the picture that the daemon has.
generation() {
    "$foveactl" stats --json >stats.json
    number generation stats.json
}

# await_generation NUMBER: it comes, and no later one.
await_generation() {
    tries=0
    until now=$(generation) && [ "$now" -ge "$1" ]; do
        tries=$((tries + 1))
        [ "$tries" -lt 300 ] || fail "generation $1 does not come: $(cat stats.json)"
        sleep 0.1
    done
    [ "$now" = "$1" ] || fail "generation $now, where $1 was to come"
}

# developed FILE: save the picture once it has paths enough to be told from another.
developed() {
    tries=0
    until "$foveactl" stats --json >stats.json && [ "$(number paths stats.json)" -ge 50000 ]; do
        tries=$((tries + 1))
        [ "$tries" -lt 600 ] || fail "too few paths: $(cat stats.json)"
        sleep 0.2
    done
    "$foveactl" save "$1" >/dev/null
}

# alike A B, different A B
alike() {
    by=$("$programs/e2e_compare" "$1" "$2")
    [ "$by" -lt 60 ] || fail "$1 and $2 differ by $by thousandths"
}
different() {
    by=$("$programs/e2e_compare" "$1" "$2")
    [ "$by" -gt 250 ] || fail "$1 and $2 differ by $by thousandths only"
}

# --- moves
start --scene room.obj $mode
"$foveactl" look 30,0
[ "$(generation)" = 1 ] || fail "the first generation is $(generation)"
developed middle.exr
"$foveactl" move 1.2,0.5,1 --json >move.json
[ "$(number generation move.json)" = 2 ] || fail "$(cat move.json)"
echo "first tile of the new generation after $(sed -n 's/.*"first_tile_ms": //p' move.json) ms"
"$foveactl" snapshot soon.png --settle 0
"$programs/e2e_picture" soon.png 256 128 >/dev/null
[ "$(generation)" = 2 ] || fail "generation $(generation) after one move"
developed moved.exr
different middle.exr moved.exr
"$foveactl" move --by -1.2,-0.5,-1 >move.txt
grep -q '^generation 3, eye 0,0,0 m; first tile after [0-9.]* ms$' move.txt || fail "$(cat move.txt)"
developed back.exr
alike middle.exr back.exr

# A picture that is being gathered when the eye moves is of the new place alone, and whole.
"$foveactl" snapshot during.exr --settle 3 &
gatherer=$!
sleep 1
"$foveactl" move 1.2,0.5,1 >/dev/null
wait "$gatherer" || fail "the snapshot failed"
"$programs/e2e_picture" during.exr 256 128 >/dev/null
different middle.exr during.exr

# Whoever watches is told, and moves that come too fast are not queued.
"$foveactl" watch --for 2 --json >watch.json &
watcher=$!
sleep 0.5
"$programs/e2e_moves" "unix:$place/fovead.sock"
wait "$watcher" || fail "watch failed"
[ "$(number generation watch.json)" -gt 4 ] || fail "watch does not tell the generation: $(cat watch.json)"

refused move "$foveactl" move 1,2
refused move "$foveactl" move nan,0,0
refused move "$foveactl" move 0,0,1e8
"$foveactl" move 9999999,0,0 >/dev/null
refused origin "$foveactl" move --by 9999999,0,0
stop
[ "$(wc -l <daemon.err)" = 0 ] || fail "the daemon complains: $(cat daemon.err)"

# A daemon that was started there has the same picture.
start --scene room.obj $mode --eye 1.2,0.5,1
developed fresh.exr
alike fresh.exr moved.exr
stop

# --- edits
start --scene room.obj $mode --watch --env sky.hdr
"$foveactl" move 0.5,0,0.5 >/dev/null
developed white.exr
sed 's/Ke 12 12 12/Ke 0 60 0/' room.mtl >new.mtl
mv new.mtl room.mtl
await_generation 3
developed green.exr
different white.exr green.exr
"$foveactl" stats | grep -q '^eye *0.5,0,0.5 m' || fail "an edit moves the eye: $("$foveactl" stats)"

# Written in place, and with a picture that only the .mtl names, in a folder of its own.
sed 's/^Kd 0.6 0.6 0.6/&\nmap_Kd pictures\/rug.jpg/' room.mtl >with.mtl
cat with.mtl >room.mtl
await_generation 4
"$foveactl" stats | grep -q '1 textures' || fail "the texture is not there: $("$foveactl" stats)"
cp "$source/fixtures/textures/marble.jpg" pictures/new.jpg
mv pictures/new.jpg pictures/rug.jpg
await_generation 5
cp "$source/fixtures/sky.hdr" sky.hdr
await_generation 6

# What the scene does not name does not count.
echo other >other.mtl
echo other >pictures/other.jpg
"$foveactl" save beside.exr >/dev/null
sleep 1
await_generation 6

# A broken edit: one line, and the picture stays; a good one after it counts again.
cp room.obj kept.obj
head -c 40 kept.obj >room.obj
tries=0
until [ -s daemon.err ]; do
    tries=$((tries + 1))
    [ "$tries" -lt 100 ] || fail "the broken edit is passed over in silence"
    sleep 0.1
done
[ "$(wc -l <daemon.err)" = 1 ] || fail "not one line: $(cat daemon.err)"
grep -q '^fovead: the edit is not taken, the picture stays: room.obj: ' daemon.err || fail "$(cat daemon.err)"
await_generation 6
"$foveactl" stats | grep -q 'the last edit was not taken: room.obj' || fail "clients are not told: $("$foveactl" stats)"
"$foveactl" snapshot kept.png --settle 0
"$programs/e2e_picture" kept.png 256 128 >/dev/null
mv kept.obj room.obj
await_generation 7
if "$foveactl" stats | grep -q 'not taken'; then fail "the old complaint stays"; fi
stop
[ "$(grep -c '^scene ' daemon.out)" = 6 ] || fail "not a line for every scene: $(cat daemon.out)"

# An edit under way when the daemon ends is no trouble.
start --scene room.obj $mode --watch
touch room.obj
sleep 0.15
stop

# --- the virtual clock
refused "real clock" "$fovead" --scene room.obj --watch --clock virtual --gaze "replay:$source/fixtures/hall.gaze"
start --scene room.obj --size 512x256 --gaze "replay:$source/fixtures/hall.gaze" --clock virtual --listen "unix:$place/fovead.sock"
refused "virtual clock" "$foveactl" move 1,0,0
stop
