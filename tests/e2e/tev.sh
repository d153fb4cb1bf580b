#!/bin/sh
# A viewer by tev's protocol: the picture reaches it whenever it comes, and at the end it holds what fovead saves. One that
# goes away, reads nothing, or is no viewer is felt by nobody.
. "$(dirname "$0")/common.sh"
make_room
port=$("$programs/e2e_port")
fake=

# view WAY...: start a viewer; what it tells is in view.out.
view() {
    rm -f view.out
    "$programs/e2e_fake_tev" "$port" "$@" >view.out 2>view.err &
    fake=$!
    await 'the viewer' viewer_says listens
}
viewer_says() {
    kill -0 "$fake" 2>/dev/null || [ "$1" = closed ] || fail "the viewer has gone: $(cat view.err)"
    grep -q "^$1" view.out
}
# view_ends: by itself, with all that came as it should be.
view_ends() {
    status=0
    wait "$fake" || status=$?
    fake=
    [ "$status" = 0 ] || fail "the viewer ends with status $status: $(cat view.err)"
}
kill_view() {
    kill -9 "$fake" 2>/dev/null || true
    wait "$fake" || true
    fake=
}

# tiles: how many the viewer has been sent.
tiles() { sed -n 's/^tiles //p' view.out | tail -n 1; }
has_more_than() { viewer_says tiles && [ "$(tiles)" -gt "$1" ]; }
# streams: a client gets tiles meanwhile.
has_tiles() { [ "$(number bytes_received watch.json)" -gt 10000 ]; }
streams() { await 'tiles at a client' watched watch.json has_tiles; }

# Nobody listens at first, which is said once.
start --scene room.obj --size 512x256 --threads 1 --gaze pointer --tev "127.0.0.1:$port" --save gazed.exr
grep -q "^viewer   127.0.0.1:$port, as soon as one is there$" daemon.out || fail "$(cat daemon.out)"
is_told() { grep -q "viewer at 127.0.0.1:$port: $1" daemon.err; }
await 'a word on the viewer' is_told 'nothing listens'
streams

# It comes: it is sent all of the picture, and where the eye looks: 30 degrees right of the middle, 10 down.
view hold first.raw
await 'the whole picture' viewer_says whole
grep -q "^created 512x256 R G B samples error 'fovead room.obj'$" view.out || fail "$(cat view.out)"
"$foveactl" look 30,-10
await 'the gaze' viewer_says 'mark 298.7 142.2$'
await 'a word on the viewer' is_told 'connected; the picture is being sent'

# It is killed and comes again: the picture is created again.
kill_view
await 'a word on the viewer' is_told 'it has gone'
view hold second.raw
await 'the whole picture again' viewer_says whole
await 'the gaze again' viewer_says 'mark 298.7 142.2$'
# The camera moves: the picture goes on in place.
before=$(tiles)
"$foveactl" move 0.5,0,0.5
await 'the picture from there' has_more_than "$((before + 64))"
kill_view

# It closes every connection at once.
view slam 50
streams
view_ends
streams
"$foveactl" stats --json >stats.json
[ "$(number generation stats.json)" = 2 ] || fail "$(cat stats.json)"

# To the end: the viewer has the same counts and errors everywhere, and the same colour where paths are.
view hold third.raw
await 'the whole picture for the third time' viewer_says whole
stop
view_ends
viewer_says closed
"$programs/e2e_same_channels" third.raw gazed.exr samples error || fail 'the viewer holds something else than was saved'
[ "$(grep -c 'nothing listens' daemon.err)" = 1 ] || fail "too many words: $(cat daemon.err)"
! grep -v "^fovead: viewer at 127.0.0.1:$port: " daemon.err || fail 'other lines'

# A picture to keep, each pixel of which has many paths: the viewer holds it as it is saved.
view hold last.raw
"$fovead" --scene room.obj --size 256x128 --until 64spp --planes all --save last.exr --tev "127.0.0.1:$port" >last.out
view_ends
grep -q '^created .* error albedo.R .* instance ' view.out || fail "no planes: $(cat view.out)"
"$programs/e2e_same_channels" last.raw last.exr || fail 'the viewer holds something else than was saved'
! grep -q mark view.out || fail 'a gaze, where there is none'

# With the virtual clock too, and the picture does not depend on the viewer.
for way in with without; do
    [ "$way" = without ] || view hold virtual.raw
    "$fovead" --scene room.obj --size 256x128 --clock virtual --gaze synthetic:3 --until 32spp --save $way.exr --tev "127.0.0.1:$port" >virtual.out 2>virtual.err
    [ "$way" = without ] || view_ends
done
cmp with.exr without.exr || fail 'the picture depends on the viewer'
"$programs/e2e_same_channels" virtual.raw with.exr samples error || fail 'the viewer holds something else than was saved'

# It reads nothing, or is no viewer at all: it is dropped, and clients do not feel it.
for case in 'deaf:it takes nothing' 'talk:this is not a viewer'; do
    view "${case%%:*}"
    start --scene room.obj --size 1024x512 --threads 1 --gaze synthetic:2 --tev "127.0.0.1:$port"
    streams
    await "the viewer to be dropped: $case" is_told "${case#*:}"
    streams
    stop
    kill_view
done
