#!/bin/sh
# Files that break programs: a scene and the files that it names are drawn, or refused in one line. They never crash the
# daemon, make it wait, or write control characters to the terminal.
. "$(dirname "$0")/common.sh"
make_room

# drawn SCENE OPTION...: is rendered, and what was said is in drawn.err.
drawn() {
    timeout 1200 "$fovead" --size 128x64 --until 1spp --sun 0,45,5,1 --scene "$@" >drawn.out 2>drawn.err </dev/null ||
        fail "not drawn: $*: status $? $(cat drawn.err)"
}

# said WORD...: drawn.err has one line, which holds the words.
said() {
    [ "$(wc -l <drawn.err)" = 1 ] || fail "not one line on stderr: $(cat drawn.err)"
    for said_word; do grep -qF -e "$said_word" drawn.err || fail "no '$said_word' in: $(cat drawn.err)"; done
}

# not_drawn WORD SCENE OPTION...
not_drawn() {
    word=$1
    shift
    refused "$word" "$fovead" --size 128x64 --until 1spp --sun 0,45,5,1 --scene "$@"
}

# plain FILE: holds no control character: C0 but line ends, DEL, C1 as a byte or as UTF-8.
plain() {
    if LC_ALL=C tr -d '\n\040-\176\240-\377' <"$1" | grep -q . ||
        LC_ALL=C grep -q "$(printf '\302[\200-\237]')" "$1"; then
        fail "control characters in $1: $(cat -v "$1")"
    fi
}

triangle() { # NAME MESH-NAME TRANSLATION
    cat >"$1.gltf" <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [$3, 0, 0]}],
 "meshes": [{"name": "$2", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
 "materials": [{"name": "$2", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
 "textures": [{"source": 0}], "images": [{"uri": "$1.png"}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "$1.bin", "byteLength": 36}]}
END
    printf '\0\0\020\301\0\0\0\0\0\0\020\301\0\0\020\101\0\0\0\0\0\0\020\301\0\0\0\0\0\0\0\0\0\0\020\101' >"$1.bin"
    printf 'P6 1 1 255\n\200\200\200' >"$1.ppm"
}

# --- what is in a file

# A map above the first material: assimp writes it to a null pointer.
for key in map_d map_Kd Kd Ns illum norm map_Bump refl; do
    printf '# all\n%s 1 1 1\nnewmtl m\nKd 1 1 1\n' "$key" >early.mtl
    printf 'mtllib early.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >early.obj
    drawn early.obj
    said "early.mtl: line 2: $key"
done
printf 'map_d a.png\n' >never.mtl
sed 's/early/never/' early.obj >never.obj
drawn never.obj
said 'never.mtl: line 1: map_d'

printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n' >corners.ply
printf 'property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 1\n3 0 1 2\n0\n' >>corners.ply
not_drawn 'corners.ply: ' corners.ply
printf 'OFF\n4 2 0\n1 0 0\n0 1 0\n1 1 1\n3 0 1 2\n3 1 2 3\n' >corners.off
not_drawn 'corners.off: ' corners.off
awk 'BEGIN {print "v 0 0 0\nv 1 0 0\nv 0 1 0"; printf "f"; for (i = 0; i < 20000; i++) printf " %d", 1 + i % 3; print ""}' >many.obj
not_drawn 'corners' many.obj

# Names that would speak to the terminal.
triangle escape '\u001b]0;pwned\u0007\u001b[31m\u007f\u0085\u009b31m' 1e30
not_drawn 'escape.gltf' escape.gltf
plain refused.err
triangle escape '\u009b31m' 0
sed -i "s/escape.png/$(printf 'no\302\2331m\033]0;x\007')/" escape.gltf
sed -i 's/\x1b/\\u001b/g; s/\x07/\\u0007/g' escape.gltf
drawn escape.gltf
said escape.gltf
plain drawn.err
name=$(printf 'a\033[31m\302\233\177b.obj')
cp early.obj "$name"
drawn "$name"
plain drawn.err
plain drawn.out
printf 'v 0 0 0\n' >"$name"
not_drawn 'a [31m' "$name"
plain refused.err

# --- what is no file: pipes, devices, folders

triangle other x 0
for kind in pipe zero folder; do
    case $kind in
    pipe) why='is a pipe' ;;
    zero) why='is a device' ;;
    folder) why='is a directory' ;;
    esac
    put() { # NAME: there is such a thing
        rm -rf "$1"
        case $kind in
        pipe) mkfifo "$1" ;;
        zero) ln -s /dev/zero "$1" ;;
        folder) mkdir "$1" ;;
        esac
    }
    for scene in put.gltf put.obj put.glb put.ply; do
        put $scene
        not_drawn "$scene: $why" $scene
        rm -rf $scene
    done
    put put.hdr
    not_drawn "put.hdr: " other.gltf --env put.hdr
    grep -q "$why" refused.err || fail "no '$why' in: $(cat refused.err)"
    put other.bin
    not_drawn "$why" other.gltf
    rm -rf other.bin
    triangle other x 0
    put other.png
    drawn other.gltf
    said other.png "$why"
    rm -rf other.png
    put early.mtl
    drawn early.obj
    said early.mtl "$why"
    rm -rf early.mtl
    refused "$why" "$foveactl" compare put.hdr put.hdr
    rm -rf put.hdr
done

# --- what a reader may take

# Faces of many corners, that take a second and more each.
awk 'BEGIN {
    for (i = 0; i < 10000; i++) printf "v %f 0 %f\n", cos(i / 10000 * 6.2831853) * (1 + (i * 7919 % 101) / 200), sin(i / 10000 * 6.2831853) * (1 + (i * 7919 % 101) / 200)
    for (face = 0; face < 400; face++) {printf "f"; for (i = 1; i <= 10000; i++) printf " %d", i; print ""}}' >slow.obj
not_drawn 'slow.obj: the reader ' slow.obj --reader-time 1
# Other work may keep the reader from having that second of the processor in ten.
grep -Eq 'took more than 1 s$|was not done after 10 s$' refused.err || fail "not out of time: $(cat refused.err)"
awk 'BEGIN {for (i = 0; i < 400000; i++) printf "v %d 0 0\n", i; for (i = 1; i < 399998; i++) print "f", i, i + 1, i + 2}' >large.obj
if ! grep -q '^SANITIZE:STRING=..*' "$programs/CMakeCache.txt"; then # sanitizers take all addresses there are
    not_drawn 'large.obj: the reader took more than 64 MiB' large.obj --reader-memory 64
fi

# readers PROGRAM: its readers of a scene.
readers() {
    for readers_one in /proc/[0-9]*; do
        if { tr '\0' ' ' <"$readers_one/cmdline"; } 2>/dev/null | grep -q "^fovead-reader $1 "; then echo "${readers_one#/proc/}"; fi
    done
}
"$fovead" --scene slow.obj --reader-time 1000 --gaze synthetic --listen "unix:$place/slow.sock" >slow.out 2>slow.err &
daemon=$!
reading() { [ -n "$(readers "$daemon")" ]; }
await 'the reader' reading
reader=$(readers "$daemon")
kill -SEGV "$reader"
wait "$daemon" && fail 'a crashed reader is success' || status=$?
[ "$status" = 1 ] && grep -q 'slow.obj: the reader crashed (signal 11)$' slow.err && [ "$(wc -l <slow.err)" = 1 ] ||
    fail "status $status: $(cat slow.err)"
"$fovead" --scene slow.obj --reader-time 1000 --gaze synthetic --listen "unix:$place/slow.sock" >slow.out 2>slow.err &
daemon=$!
await 'the reader' reading
reader=$(readers "$daemon")
kill -TERM "$daemon"
wait "$daemon" || true
is_gone() { ! kill -0 "$reader" 2>/dev/null; }
await 'the end of the reader' is_gone
daemon=

# --- the daemon goes on

# edited WORD: the daemon has taken the edit up, or said why not, in a line that holds WORD.
edited() {
    kill -0 "$daemon" || fail "the daemon has gone: $*"
    grep -qF -e "$1" daemon.err daemon.out
}
cp room.obj own.obj
sed -i 's/room.mtl/own.mtl/' own.obj
cp room.mtl own.mtl
start --scene own.obj --reader-time 1000 --watch --size 128x64 --gaze synthetic
mkfifo aaa.mtl
ln -s /dev/zero zero.mtl
printf 'map_d own.png\n' | cat - room.mtl >next && mv next own.mtl
await 'the edit of own.mtl' edited 'own.mtl: line 1: map_d'
cat corners.ply >next && mv next own.obj
await 'the refusal' edited 'the picture stays: '
mkfifo next && mv next own.obj
await 'the refusal of a pipe' edited 'own.obj: is a pipe'
"$foveactl" stats >/dev/null || fail 'the daemon does not answer'
cat slow.obj >next && mv next own.obj
await 'the reader' reading
kill -SEGV "$(readers "$daemon")"
await 'the crash' edited 'the picture stays: own.obj: the reader crashed (signal 11)'
"$foveactl" stats >/dev/null || fail 'the daemon does not answer'
sed 's/room.mtl/own.mtl/' room.obj >next && mv next own.obj
await 'the last edit' sh -c '[ "$(grep -c "^scene " daemon.out)" = 3 ]'
cat slow.obj >next && mv next own.obj
await 'the reader' reading
stop

# --- the files of ../shared, if they are here
cases=$source/../shared/cases/files
[ -d "$cases" ] || { echo "the rest is left out: $cases is not here"; exit 0; }
drawn "$cases/map-before-newmtl.obj"
said 'map-before-newmtl.mtl: line 1: map_d'
not_drawn face-of-no-corner.ply "$cases/face-of-no-corner.ply"
not_drawn vertex-missing.off "$cases/vertex-missing.off"
not_drawn polygon-300000.obj "$cases/polygon-300000.obj"
not_drawn terminal-escape.gltf "$cases/terminal-escape.gltf"
plain refused.err
# 261 KB that become 1.4 GiB: fovead states that textures take 2 GiB at most. With the virtual clock all of them are there
# before the first path.
if ! grep -q '^SANITIZE:STRING=..*' "$programs/CMakeCache.txt"; then
    start --scene "$cases/texture-16384.gltf" --sun 0,45,5,1 --size 128x64 --clock virtual --listen "unix:$place/large.sock" \
        --until 1000000spp
    peak=$(sed -n 's/^VmHWM:[[:space:]]*\([0-9]*\) kB$/\1/p' "/proc/$daemon/status")
    [ "$peak" -gt 1000000 ] && [ "$peak" -lt 2600000 ] || fail "a texture of 1.4 GiB took $peak KiB"
    kill -9 "$daemon"
    daemon=
fi
