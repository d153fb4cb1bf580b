#!/bin/sh
# Every scene of glTF's features and every Cornell box still looks as it did when it was checked against the
# specification: a picture with a few paths per pixel is close to the golden image, which had many more. The project
# does not own the scenes, so the test is skipped where they are absent.
#
#   golden.sh PROGRAMS SOURCE               compare all
#   golden.sh PROGRAMS SOURCE make [NAME]   write all of tests/golden, or one; look at the images before you keep them
. "$(dirname "$0")/common.sh"
mode=${3-compare}
only=${4-}
data=$source/../shared/data
scenes=$data/scenes
golden=$source/tests/golden
[ -d "$scenes/gltf-tests" ] && [ -d "$scenes/cornell-box" ] || { echo "skipped: $scenes is not here"; exit 77; }

# Scene, position of the camera (-Z is ahead), and the largest mean of FLIP, which is 1.5 times what noise alone causes
# with another seed than the golden image's.
cases() {
    cat <<'END'
gltf-tests/Box.glb                           0.9,0.7,1.2      0.024
gltf-tests/01_alpha_blend                    4.5,4.5,5        0.023
gltf-tests/01_alpha_mask                     0,1,2.2          0.019
gltf-tests/01_color_attribute                0,1,2.2          0.020
gltf-tests/01_metallic_sphere                0,0.3,2          0.017
gltf-tests/01_principled_material            1.2,0.8,2.6      0.022
gltf-tests/01_single_vs_double_sided         -1.25,1.4,2.4    0.031
gltf-tests/01_unlit                          0,0.5,2.6        0.020
gltf-tests/01_vertex_count_32bit             1.5,1,4.5        0.024
gltf-tests/02_node_hierarchy                 2,2,4            0.022
gltf-tests/02_shared_mesh                    2,0.8,3.5        0.027
gltf-tests/02_suzanne                        0.2,-0.5,1.8     0.025
gltf-tests/03_animated_cube                  1.8,1.4,2.4      0.023
gltf-tests/04_sphere_specular_glossiness     0,0.3,2          0.029
gltf-tests/05_metallic_sphere_light          0,0.5,2.5        0.048
gltf-tests/09_texture_transform              0,1,2.2          0.023
gltf-tests/10_custom_normals                 -1.25,0.6,2.8    0.020
gltf-tests/13_texture_wrapping               -1.5,1.2,2.6     0.022
gltf-tests/14_emission_strength              17,0.3,6         0.021
gltf-tests/15_transmission                   4,0.3,3.5        0.030
gltf-tests/16_volume                         -0.5,1,8         0.064
gltf-tests/17_ior                            6,0.3,4          0.033
gltf-tests/18_variants                       0.8,1.6,2.4      0.029
gltf-tests/19_sheen                          6,0.3,3.5        0.029
gltf-tests/20_specular                       6,0.3,3.5        0.028
gltf-tests/22_vertex_color                   -0.5,2.4,7.5     0.018
gltf-tests/24_gpu_instancing                 0,40,120         0.119
gltf-tests/25_anisotropy                     0.5,4.5,5        0.045
cornell-box/CornellBox-Empty-CO.obj          0,0.8,1.2        0.090
cornell-box/CornellBox-Empty-RG.obj          0,0.8,1.2        0.102
cornell-box/CornellBox-Empty-Squashed.obj    0,0.8,1.2        0.086
cornell-box/CornellBox-Empty-White.obj       0,0.8,1.2        0.135
cornell-box/CornellBox-Glossy-Floor.obj      0,0.8,1.2        0.098
cornell-box/CornellBox-Glossy.obj            0,0.8,1.2        0.097
cornell-box/CornellBox-Mirror.obj            0,0.8,1.2        0.125
cornell-box/CornellBox-Original.obj          0,0.8,1.2        0.098
cornell-box/CornellBox-Sphere.obj            0,0.8,1.2        0.107
cornell-box/CornellBox-Water.obj             0,0.8,1.2        0.125
END
}
case $mode in
make) paths=512 seed=1 ;;
compare) paths=64 seed=2 ;;
*) fail "expected make or compare, not $mode" ;;
esac

# take SCENE CAMERA: render the scene to picture.png.
take() {
    file=$scenes/$1
    [ ! -d "$file" ] || file=$file/${1##*/}.gltf
    # The emitter of the two glossy boxes is a material that is missing in their library, so they need an environment.
    case $1 in
    gltf-tests/* | *-Glossy*) set -- "$@" --env "$data/envmaps/st_fagans_interior_1k.hdr" ;;
    esac
    camera=$2
    shift 2
    "$fovead" --scene "$file" --camera "$camera" --size 256x128 --until "${paths}spp" --seed $seed --save saved.exr --json \
        "$@" >daemon.json 2>daemon.err </dev/null || fail "$file is not rendered: $(cat daemon.err)"
    [ "$(number not_finite daemon.json)" = 0 ] || fail "$file: $(cat daemon.json)"
    "$programs/e2e_golden" saved.exr picture.png
}

# This scene contains nothing that could be rendered.
refused "expected nodes" "$fovead" --scene "$scenes/gltf-tests/00_no_nodes/00_no_nodes.gltf" --until 1spp

cases >cases
for file in "$scenes"/gltf-tests/*_* "$scenes"/gltf-tests/*.glb "$scenes"/cornell-box/*.obj; do
    [ "${file##*/}" = 00_no_nodes ] || grep -qF "${file#"$scenes"/} " cases || fail "no case renders $file"
done
worst=0
found=
while read -r scene camera limit; do
    name=${scene##*/}
    name=${name%.*}
    [ -z "$only" ] || [ "$only" = "$name" ] || continue
    found=1
    rm -f near.json
    take "$scene" "$camera"
    if [ "$mode" = make ]; then
        mv picture.png "$golden/$name.png"
        continue
    fi
    (near "$limit" "$golden/$name.png" picture.png) || worst=1
    echo "$name $(sed -n 's/^ *"mean": \(.*\),$/\1/p' near.json), at most $limit"
done <cases
[ "$found" ] || fail "no case is named $only"
[ "$worst" = 0 ] || fail "some pictures differ from their golden images"
