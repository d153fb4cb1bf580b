#!/bin/sh
# The camera moves and the scene is edited while clients watch. Each change begins a new generation of the picture, in
# which nothing of the old one is left.
. "$(dirname "$0")/common.sh"
make_room
mkdir pictures
cp "$source/fixtures/textures/rug.jpg" pictures/rug.jpg
cp "$source/fixtures/sky.hdr" sky.hdr
mode="--size 256x128 --mode od --gaze pointer"

# generation: print the generation of the daemon's picture.
generation() {
    "$foveactl" stats --json >stats.json
    number generation stats.json
}

# await_generation NUMBER: wait for this generation; no later one may come.
await_generation() {
    await "generation $1" told stats.json generation "$1"
    [ "$(number generation stats.json)" = "$1" ] || fail "generation $(number generation stats.json), where $1 was expected"
}

# developed FILE: save the picture once it has 7 paths per pixel, when hardly a pixel is black for lack of a path.
developed() {
    await 'enough paths' told stats.json paths 250000
    "$foveactl" save "$1" >/dev/null
}

# alike A B, different A B: two pictures show the same, or not.
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
grep -q '^generation 3, camera 0,0,0 m; first tile after [0-9.]* ms$' move.txt || fail "$(cat move.txt)"
developed back.exr
alike middle.exr back.exr

# If the camera moves while a snapshot is gathered, the snapshot is whole and shows only the new place. On a machine so
# slow that the snapshot was complete before the camera moved, try again with more time.
settle=2
gathers_while_it_moves() {
    settle=$((settle * 2))
    "$foveactl" move 0,0,0 >/dev/null
    "$foveactl" snapshot during.exr --settle $settle &
    gatherer=$!
    sleep 1
    "$foveactl" move 1.2,0.5,1 >/dev/null
    in_time=true
    kill -0 "$gatherer" 2>/dev/null || in_time=false
    wait "$gatherer" || fail "the snapshot failed"
    $in_time
}
await 'a picture that is gathered while the camera moves' gathers_while_it_moves
"$programs/e2e_picture" during.exr 256 128 >/dev/null
different middle.exr during.exr

# Moves that come faster than they can be rendered are not queued. The stream tells the newest generation.
before=$(generation)
"$programs/e2e_moves" "unix:$place/fovead.sock"
tells_moves() { [ "$(number generation watch.json)" -gt "$before" ]; }
await 'the generation of the moves in watch' watched watch.json tells_moves

refused move "$foveactl" move 1,2
refused move "$foveactl" move nan,0,0
refused move "$foveactl" move 0,0,1e8
"$foveactl" move 9999999,0,0 >/dev/null
refused origin "$foveactl" move --by 9999999,0,0
stop
[ "$(wc -l <daemon.err)" = 0 ] || fail "the daemon complains: $(cat daemon.err)"

# A daemon that starts at that place renders the same picture.
start --scene room.obj $mode --camera 1.2,0.5,1
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
"$foveactl" stats | grep -q '^camera *0.5,0,0.5 m' || fail "an edit moves the camera: $("$foveactl" stats)"

# The file is written in place, so a half-written one may be read first. The .mtl names a picture in a folder of its
# own, in the way of Windows.
has_texture() { "$foveactl" stats | grep -q '1 textures'; }
sed 's/^Kd 0.6 0.6 0.6/&\nmap_Kd Pictures\\RUG.JPG/' room.mtl >with.mtl
cat with.mtl >room.mtl
await 'the texture' has_texture
now=$(generation)
[ "$now" -ge 4 ] || fail "a texture in generation $now"
cp "$source/fixtures/textures/marble.jpg" pictures/new.jpg
mv pictures/new.jpg pictures/rug.jpg
await_generation $((now += 1))
cp "$source/fixtures/sky.hdr" new.hdr
mv new.hdr sky.hdr
await_generation $((now += 1))

# A change of a file that the scene does not name has no effect.
echo other >other.mtl
echo other >pictures/other.jpg
"$foveactl" save beside.exr >/dev/null
sleep 1
await_generation $now

# A broken edit gives one line, and the picture stays. A good edit after it is taken.
cp room.obj kept.obj
head -c 40 kept.obj >broken.obj
mv broken.obj room.obj
await 'a line on the broken edit' [ -s daemon.err ]
[ "$(wc -l <daemon.err)" = 1 ] || fail "not one line: $(cat daemon.err)"
grep -q '^fovead: the edit is not taken, the picture stays: room.obj: ' daemon.err || fail "$(cat daemon.err)"
await_generation $now
"$foveactl" stats | grep -q 'the last edit was not taken: room.obj' || fail "clients are not told: $("$foveactl" stats)"
"$foveactl" snapshot kept.png --settle 0
"$programs/e2e_picture" kept.png 256 128 >/dev/null
mv kept.obj room.obj
await_generation $((now += 1))
if "$foveactl" stats | grep -q 'not taken'; then fail "the old complaint is still there"; fi
[ "$(wc -l <daemon.err)" = 1 ] || fail "changes beside a broken scene are reported: $(cat daemon.err)"
stop
[ "$(grep -c '^scene ' daemon.out)" = $((now - 1)) ] || fail "not one line per scene: $(cat daemon.out)"

# An edit that names a missing file is taken when that file appears. Its triangle has the corners 0,0,0  1,0,0  0,1,0.
{
    head -c 12 /dev/zero
    printf '\000\000\200\077'
    head -c 12 /dev/zero
    printf '\000\000\200\077'
    head -c 4 /dev/zero
} >corner.bin
cat >corner.gltf <<'END'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], "materials": [{"emissiveFactor": [1, 1, 1]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "corner.bin"}]}
END
start --scene corner.gltf $mode --watch
sed 's/corner.bin/later%20on.bin/' corner.gltf >new.gltf
mv new.gltf corner.gltf
await 'a line on the missing file' grep -q 'later on.bin' daemon.err
await_generation 1
cp corner.bin 'later on.bin'
await_generation 2
stop

# A daemon may end while it takes up an edit.
start --scene room.obj $mode --watch
touch room.obj
sleep 0.15
stop

# --- the virtual clock
refused "real clock" "$fovead" --scene room.obj --watch --clock virtual --gaze "replay:$source/fixtures/hall.gaze"
start --scene room.obj --size 512x256 --gaze "replay:$source/fixtures/hall.gaze" --clock virtual --listen "unix:$place/fovead.sock"
refused "virtual clock" "$foveactl" move 1,0,0
stop
