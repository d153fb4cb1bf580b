#!/bin/sh
# Scenes whose light is known in advance, each for one kind of fault: the files in ../shared/cases/scene. The unit tests
# have scenes of their own for each kind; this test renders the files as an artist would. It is skipped where they are
# absent.
. "$(dirname "$0")/common.sh"
cases=$source/../shared/cases/scene
[ -d "$cases" ] || { echo "skipped: $cases is not here"; exit 77; }
worst=0

# shown NAME OPTION...: render NAME.gltf to NAME.exr, with the output in NAME.out.
shown() {
    name=$1
    shift
    timeout 1200 "$fovead" --scene "$cases/$name.gltf" --gaze pointer --mode od --size 128 --until 256spp --save "$name.exr" \
        "$@" >"$name.out" 2>&1 </dev/null || fail "$name is not rendered: $(cat "$name.out")"
}

# mean NAME LOW HIGH [LEFT TOP RIGHT BOTTOM]: the mean of this part of NAME.exr must be from LOW to HIGH.
mean() {
    name=$1 low=$2 high=$3
    shift 3
    value=$("$programs/e2e_mean" "$name.exr" "$@")
    echo "$name: $value, expected $low to $high"
    awk "BEGIN {exit !($value >= $low && $value <= $high)}" || worst=1
}

# ratio ONE OTHER LOW HIGH: the same for the quotient of the means of two whole pictures.
ratio() {
    value=$(awk "BEGIN {print $("$programs/e2e_mean" "$1.exr") / $("$programs/e2e_mean" "$2.exr")}")
    echo "$1 / $2: $value, expected $3 to $4"
    awk "BEGIN {exit !($value >= $3 && $value <= $4)}" || worst=1
}

# same ONE OTHER LIMIT: parts of the two pictures may differ by at most LIMIT thousandths.
same() {
    value=$("$programs/e2e_compare" "$1.exr" "$2.exr")
    echo "$1 and $2 differ by $value thousandths, expected at most $3"
    [ "$value" -le "$3" ] || worst=1
}

# Coverage of emitters. The emitter has radiance 10 and 2 x 2 m, and is 2 m above the floor: below its middle the floor
# has a radiance of 0.8 x 10 x 0.2394.
for name in opaque10 blend50 mask20; do shown $name; done
mean opaque10 1.895 1.935 0 0.96875 1 1
mean blend50 0.948 0.967 0 0.96875 1 1
mean mask20 0 0

# Rare light: a picture is never converged while it is black. The light is found where glass is clear for shadow rays.
shown bulb --camera 0,1.3,0 --bounces 4
grep -q ', 0 converged' bulb.out || mean bulb 0.36 0.44
shown bulb --camera 0,1.3,0 --bounces 4 --clear-glass
mean bulb 0.4 0.48
for name in bare dim; do shown $name --camera 0,1.3,0 --bounces 4 --until converged; done
mean bare 0.43 0.45
mean dim 4.3e-6 4.5e-6

# Mirrored instances, and tangents that the file states.
for name in mir_inst mir_flat nomir_inst nomir_flat tan0 tan1; do shown $name --sun 70,35,5,20 --camera 0,3,0; done
same mir_inst mir_flat 10
same nomir_inst nomir_flat 10
value=$("$programs/e2e_compare" tan0.exr tan1.exr)
echo "tan0 and tan1 differ by $value thousandths, expected at least 100"
[ "$value" -ge 100 ] || worst=1

# Pictures of 8 and 16 bits, and texture coordinates as integers and floats, mean the same.
for name in png8 png16; do shown $name --camera 0,1,0; done
for name in uv-ushort uv-float; do shown $name --camera 0,0,0; done
for name in png8 png16; do mean $name 0.2145 0.2175 0 0.95 1 1; done
same uv-ushort uv-float 1
shown nomir_flat --env "$cases/env8.png" --camera 0,3,0
mean nomir_flat 0.2145 0.2175 0 0 1 0.1

# Files that other programs read.
for name in percent-encoded-buffer root-is-also-child; do shown $name --camera 0,0,0 --env "$cases/const.hdr"; done
grep -qi 'root' root-is-also-child.out || { echo "root-is-also-child: no line says so: $(cat root-is-also-child.out)"; worst=1; }
"$fovead" --scene "$cases/requires-unknown-extension.gltf" --until 1spp >unknown.out 2>&1 </dev/null || true
grep -q XX_made_up unknown.out || { echo "XX_made_up is not named: $(cat unknown.out)"; worst=1; }

# A mirror whose shading normal reflects below the surface.
for name in normal-n0_0_1 normal-n50_0_1 normal-n50_0.3_1; do
    shown $name --env "$cases/const.hdr" --camera 0,0,0
    mean $name 0.9 1.02 0.48 0.48 0.52 0.52
done

# A room far from the origin.
shown room-at-0 --env "$cases/const.hdr" --camera 0.3,1.4,0.2 --until 1024spp
shown room-at-10km --env "$cases/const.hdr" --camera 10000.3,1.4,5000.2 --until 1024spp
ratio room-at-10km room-at-0 0.998 1.002

[ "$worst" = 0 ] || fail "some scenes do not have the expected light"
