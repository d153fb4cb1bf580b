#!/bin/sh
# Programs that read no pictures load no library for pictures. The programs that read them also work once they are
# installed.
. "$(dirname "$0")/common.sh"

# loads PROGRAM NUMBER WORD...: the program must load fewer libraries than NUMBER, and none with one of the words in its
# name. Programs load no library by name later, so the list is complete.
loads() {
    program=$1
    most=$2
    shift 2
    LD_TRACE_LOADED_OBJECTS=1 "$programs/$program" >libraries
    for word in "$@"; do
        if grep "$word" libraries; then fail "$program loads a library that it does not need"; fi
    done
    [ "$(wc -l <libraries)" -lt "$most" ] || fail "$program loads $(wc -l <libraries) libraries: $(cat libraries)"
}
loads foveactl 30 OpenImageIO OpenEXR assimp embree
loads fovead 40 OpenImageIO OpenEXR assimp
for program in foveactl-image fovead-image; do
    LD_TRACE_LOADED_OBJECTS=1 "$programs/$program" | grep -q OpenImageIO || fail 'this way of listing libraries does not show OpenImageIO'
done

# foveactl finds the program that reads pictures beside itself, however foveactl is called.
cmake --install "$programs" --prefix "$place/own" >/dev/null
ln -s own/bin/foveactl link
for ctl in own/bin/foveactl ./link; do
    "$ctl" compare --json "$source/fixtures/preview.jpg" "$source/fixtures/preview.jpg" >same.json || fail "$ctl compares nothing"
    grep -q '"mean": 0[.,]' same.json || fail "$(cat same.json)"
    "$ctl" gaze info "$source/fixtures/hall.gaze" >/dev/null
done

# fovead lets the program beside it write pictures, and says so at once if that is missing.
make_room
own/bin/fovead --scene room.obj --size 128x64 --until 1spp --save own.exr >/dev/null
"$programs/e2e_mean" own.exr >/dev/null || fail 'no picture'
rm own/bin/fovead-image
refused 'own/bin/fovead-image: No such file' own/bin/fovead --scene room.obj --size 128x64 --until 1spp --save none.exr
rm own/bin/foveactl-image
refused 'own/bin/foveactl-image: No such file' own/bin/foveactl compare a.png b.png
refused 'usage: foveactl compare' own/bin/foveactl compare a.png
