#!/bin/sh
# What fovead saves: pictures for displays, marked as panoramas, and planes.
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
