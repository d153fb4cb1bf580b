#!/bin/sh
# Bad input of any kind gives one clear line that names the fault and a status that is not 0. It never causes a hang.
. "$(dirname "$0")/common.sh"
make_room
make_log

# bad WORD OPTION...: refused, with options that would otherwise start a small render that ends by itself.
bad() {
    word=$1
    shift
    refused "$word" "$fovead" --size 128x64 --until 1spp "$@"
}

# The good input that the others are made from.
"$fovead" --size 128x64 --until 1spp --scene room.obj --gaze replay:short.gaze >good.out 2>good.err ||
    fail "the good case: $(cat good.err)"

# --- scenes: a triangle in glTF, with one fault each
gltf() { # FILE MESH-AND-NODES BUFFER
    cat >"$1" <<END
{"asset": {"version": "2.0"}, $2
 "materials": [{"emissiveFactor": [1, 1, 1]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, -1], "max": [1, 1, -1]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"uri": "$3", "byteLength": 36}]}
END
}
mesh='"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],'
node='"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],'
one='\0\0\200\077'
away='\0\0\200\277'
zero='\0\0\0\0'
printf "$zero$zero$away$one$zero$away$zero$one$away" >good.bin
printf "$zero$zero$away$one\\0\\0\\300\\177$away$zero$one$away" >nan.bin
gltf good.gltf "$node $mesh" good.bin
"$fovead" --size 128x64 --until 1spp --scene good.gltf --camera 0,0,0 >good.out 2>good.err ||
    fail "the good triangle: $(cat good.err)"

bad missing.gltf --scene missing.gltf
bad "$place" --scene "$place"
head -c 200 good.gltf >truncated.gltf
bad truncated.gltf --scene truncated.gltf
: >empty.gltf
bad empty.gltf --scene empty.gltf
gltf absent.gltf "$node $mesh" absent.bin
bad absent --scene absent.gltf
head -c 20 good.bin >short.bin
gltf short.gltf "$node $mesh" short.bin
bad short --scene short.gltf
gltf nodeless.gltf "$mesh" good.bin
bad nodeless.gltf --scene nodeless.gltf
gltf nan.gltf "$node $mesh" nan.bin
bad nan.gltf --scene nan.gltf
sed 's/^v 2 2 2$/v 2 nan 2/' room.obj >nan.obj
bad nan.obj --scene nan.obj
sed '/^Ke/d' room.mtl >dark.mtl
sed 's/room.mtl/dark.mtl/' room.obj >dark.obj
bad dark.obj --scene dark.obj
head -c 5000 /dev/urandom >noise.gltf
bad noise.gltf --scene noise.gltf
no_nodes=$source/../shared/data/scenes/gltf-tests/00_no_nodes/00_no_nodes.gltf
if [ -f "$no_nodes" ]; then bad 00_no_nodes --scene "$no_nodes"; else echo "no shared data: its file is left out"; fi

# --- images
echo "not an image" >words.hdr
bad words.hdr --scene room.obj --env words.hdr
bad missing.hdr --scene room.obj --env missing.hdr
head -c 3000 /dev/urandom >noise.exr
bad noise.exr --scene room.obj --env noise.exr
gltf textured.gltf "$node $mesh" good.bin
sed -i 's/"emissiveFactor"/"emissiveTexture": {"index": 0}, &/; s/"materials"/"images": [{"uri": "words.png"}], "textures": [{"source": 0}], &/' textured.gltf
echo "not an image" >words.png
# A scene is rendered without an image that cannot be read, and one line names the image.
without() {
    "$fovead" --size 128x64 --until 4spp --camera 0,0,0 --scene "$1" >without.out 2>without.err ||
        fail "$1: $(cat without.err)"
    [ "$(grep -c "warning: words.png: " without.err)" = 1 ] || fail "$1: $(cat without.err)"
}
without textured.gltf
sed 's/"emissiveTexture": {"index": 0}, //; s/"materials": \[{/&"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, /' textured.gltf >late.gltf
without late.gltf # this image is read after rendering has begun

# --- gaze logs
log_refused() { bad "$1" --scene room.obj --gaze "replay:$1"; }
log_refused missing.gaze
head -n 2 short.gaze >rowless.gaze
log_refused rowless.gaze
: >empty.gaze
log_refused empty.gaze
sed '2s/arrival/departure/' short.gaze >header.gaze
log_refused header.gaze
sed '1s/1/99/' short.gaze >version.gaze
log_refused version.gaze
awk 'NR == 50 {held = $0; next} {print} NR == 51 {print held}' short.gaze >backwards.gaze
log_refused backwards.gaze
awk 'NR == 60 {$5 = "nan"} {print}' short.gaze >nan.gaze
log_refused nan.gaze
awk 'NR == 60 {$5 = "inf"} {print}' short.gaze >inf.gaze
log_refused inf.gaze
head -c 5000 /dev/urandom >noise.gaze
log_refused noise.gaze
bad telepathy --scene room.obj --gaze telepathy

# --- options
bad --nonsense --scene room.obj --nonsense
bad --scene --size 128
bad 100x50 --scene room.obj --size 100x50
bad --env --scene room.obj --env
bad no/such/folder --scene room.obj --save no/such/folder/x.exr

# --- sockets
bad no/such/folder --scene room.obj --listen "unix:$place/no/such/folder/socket"
bad /proc/fovead.socket --scene room.obj --listen unix:/proc/fovead.socket
bad "$(printf '%0100d' 0)" --scene room.obj --listen "unix:/$(printf '%0200d' 0)"
address=tcp:127.0.0.1:$("$programs/e2e_port")
start --scene room.obj --size 128x64 --gaze synthetic --listen "$address"
bad "${address#tcp:}" --scene room.obj --listen "$address"
grep -q "in use" refused.err || fail "the line does not say that the port is in use: $(cat refused.err)"
stop

# --- the client
refused "$place/fovead.sock" "$foveactl" stats
refused nowhere.exr "$foveactl" samples nowhere.exr out.png
refused noise.exr "$foveactl" samples noise.exr out.png
refused dance "$foveactl" dance
refused --nonsense "$foveactl" stats --nonsense
refused --settle "$foveactl" snapshot a.png --settle
refused --view "$foveactl" snapshot a.png --view 1,2
refused a.gif "$foveactl" snapshot a.gif
refused look "$foveactl" look
refused 'look wants' "$foveactl" look up
