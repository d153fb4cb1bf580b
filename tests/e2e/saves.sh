#!/bin/sh
# What fovead saves: at intervals while it runs, as pictures for displays that are marked as panoramas, and planes.
. "$(dirname "$0")/common.sh"
make_room
make_log
mean() { "$programs/e2e_mean" "$@" || fail "cannot be read: $*"; }
larger() { awk "BEGIN {exit !($1 > $2)}"; }

# marked FILE WIDTH HEIGHT: a panorama for viewers, and a whole picture.
marked() {
    "$programs/e2e_picture" "$1" "$2" "$3" >/dev/null || fail "no whole picture: $1"
    for property in UsePanoramaViewer='"True"' ProjectionType='"equirectangular"' FullPanoWidthPixels="\"$2\"" \
        FullPanoHeightPixels="\"$3\"" CroppedAreaImageWidthPixels="\"$2\"" CroppedAreaImageHeightPixels="\"$3\"" \
        CroppedAreaLeftPixels='"0"' CroppedAreaTopPixels='"0"' PoseHeadingDegrees='"0"'; do
        grep -aqF "GPano:$property" "$1" || fail "$1 has no GPano:$property"
    done
    if command -v exiftool >/dev/null; then
        exiftool -s3 -XMP-GPano:ProjectionType -XMP-GPano:FullPanoWidthPixels -XMP-GPano:UsePanoramaViewer "$1" | tr '\n' ' ' >exif
        [ "$(cat exif)" = "equirectangular $2 True " ] || fail "exiftool reads from $1: $(cat exif)"
    fi
}

# --- at intervals

small="--scene room.obj --size 256x128 --gaze synthetic:7"
start $small --save auto.exr --save-every 1
await 'the first save' test -e auto.exr
first=$(mean auto.exr samples)
larger "$first" 0 || fail "an empty picture was saved: $first"
grown() { larger "$(mean auto.exr samples)" "$first"; }
await 'a better picture' grown
"$foveactl" save asked.exr >/dev/null || fail 'clients cannot save meanwhile'
saved_again() { larger "$(mean auto.exr samples)" "$(mean asked.exr samples)"; }
await 'a picture after that' saved_again
last=$(mean auto.exr samples)
stop
larger "$(mean auto.exr samples)" "$last" || fail 'the last picture is not that of the end'
[ ! -s daemon.err ] || fail "the daemon complains: $(cat daemon.err)"

# Killed at any time, it leaves the last whole picture.
for pause in 0.3 0.9; do
    rm auto.exr
    start $small --save auto.exr --save-every 1
    await 'the first save' test -e auto.exr
    sleep $pause
    kill -9 "$daemon"
    wait "$daemon" || true
    daemon=
    larger "$(mean auto.exr samples)" 0 || fail 'the picture has gone'
done

# One that cannot be written is told once, and rendering goes on; so is the first that can be written again.
mkdir away
start $small --save away/auto.png --save-every 1
await 'the first save' test -e away/auto.png
mv away gone
await 'a word that it fails' grep -q 'away/auto.png: cannot be written: No such file' daemon.err
sleep 2.5
"$foveactl" stats >/dev/null || fail 'the daemon does not go on'
mkdir away
await 'a word that it works' grep -q 'the film is saved again: wrote away/auto.png' daemon.err
marked away/auto.png 256 128
[ "$(wc -l <daemon.err)" = 2 ] || fail "not two lines: $(cat daemon.err)"
stop

# --- pictures for displays

start --scene room.obj --size 256x128 --gaze pointer --mode od
shown() { told stats.json paths $((256 * 128 * 64)); }
await '64 paths per pixel' shown
for end in png jpg jpeg PNG; do
    "$foveactl" save "shot.$end" --exposure 1 >/dev/null || fail "not saved as .$end"
    marked "shot.$end" 256 128
    "$foveactl" snapshot "view.$end" --exposure 1 --settle 0 >/dev/null
    marked "view.$end" 256 128
done
near 0.1 view.png shot.png # they are not of the same time
"$foveactl" save auto.jpg --exposure auto >/dev/null
"$foveactl" save dark.jpg --exposure=-3 >/dev/null
larger "$(mean shot.jpg)" "$(mean auto.jpg)" || larger "$(mean auto.jpg)" "$(mean dark.jpg)" || fail 'no exposure'
"$foveactl" save plain.exr >/dev/null
refused 'has no channel "albedo.R"' "$programs/e2e_mean" plain.exr albedo.R
for bad in shot.tif shot noending/ .exr.gz; do refused '.exr, .png or .jpg' "$foveactl" save "$bad"; done
for bad in shot.tif shot; do
    refused '.exr, .png or .jpg' "$foveactl" snapshot "$bad"
    refused '.exr, .png or .jpg' "$foveactl" samples plain.exr "$bad"
    refused '.exr, .png or .jpg' "$foveactl" compare plain.exr plain.exr --map "$bad"
    refused '.exr, .png or .jpg' "$fovead" --scene room.obj --save "$bad"
done
stop

# --- planes, and the same files with any threads

for threads in 1 3; do
    for file in all.exr all.png all.jpg; do
        "$fovead" --scene room.obj --size 256x128 --gaze replay:short.gaze --clock virtual --until 0.2s --threads $threads \
            --planes all --save $threads-$file >/dev/null
    done
done
for file in all.exr all.png all.jpg; do cmp 1-$file 3-$file || fail "other threads, another $file"; done
"$fovead" --scene room.obj --size 256x128 --gaze replay:short.gaze --clock virtual --until 0.2s --save none.exr >/dev/null
for channel in R G B samples error; do
    [ "$(mean none.exr $channel)" = "$(mean 1-all.exr $channel)" ] || fail "planes change $channel"
done
"$fovead" --scene room.obj --size 256x128 --until 16spp --planes position,albedo --save some.exr >/dev/null 2>&1
[ "$(mean some.exr coverage)" = 1 ] || fail "coverage in a closed room is $(mean some.exr coverage)"
larger "$(mean some.exr albedo.R)" 0.5 && larger 0.5 "$(mean some.exr albedo.G)" || fail "albedo is not that of walls of 0.6 and some of 0.7,0.1,0.1"
refused 'has no channel "normal.X"' "$programs/e2e_mean" some.exr normal.X
refused "there is no 'depth', expected all or some of albedo,normal,position,coverage,instance" "$fovead" --scene room.obj --planes depth
refused 'the real clock' "$fovead" --scene room.obj --gaze replay:short.gaze --clock virtual --save a.exr --save-every 5
