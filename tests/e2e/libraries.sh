#!/bin/sh
# What needs no pictures loads no library for them; what does, works also where it is installed.
. "$(dirname "$0")/common.sh"

# Nothing is loaded later by name: what the program is linked with is what every command of it has.
LD_TRACE_LOADED_OBJECTS=1 "$foveactl" >libraries
if grep -e OpenImageIO -e assimp -e embree libraries; then fail "foveactl loads what it has no use for"; fi
[ "$(wc -l <libraries)" -lt 30 ] || fail "foveactl loads $(wc -l <libraries) libraries: $(cat libraries)"
LD_TRACE_LOADED_OBJECTS=1 "$programs/foveactl-image" | grep -q OpenImageIO || fail 'OpenImageIO is not to be seen this way'

# The program that has them is found beside foveactl, by whatever way that is called.
cmake --install "$programs" --prefix "$place/own" >/dev/null
ln -s own/bin/foveactl link
for ctl in own/bin/foveactl ./link; do
    "$ctl" compare --json "$source/fixtures/preview.jpg" "$source/fixtures/preview.jpg" >same.json || fail "$ctl compares nothing"
    grep -q '"mean": 0[.,]' same.json || fail "$(cat same.json)"
    "$ctl" gaze info "$source/fixtures/hall.gaze" >/dev/null
done
rm own/bin/foveactl-image
refused 'own/bin/foveactl-image: No such file' own/bin/foveactl compare a.png b.png
refused 'usage: foveactl compare' own/bin/foveactl compare a.png
