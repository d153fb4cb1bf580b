# For test scripts: waiting for an event however slow the machine is, and a small scene to render.

# await WHAT COMMAND...: repeat the command until it succeeds. The count only serves to name an event that never comes.
await() {
    awaited=$1
    shift
    left=6000
    until "$@"; do
        left=$((left - 1))
        [ "$left" -gt 0 ] || fail "waited in vain for $awaited"
        sleep 0.1
    done
}

# A box of 4 m with an emitter under the ceiling. The camera is in its middle.
make_room() {
    cat >room.mtl <<'END'
newmtl wall
Kd 0.6 0.6 0.6
newmtl red
Kd 0.7 0.1 0.1
newmtl emitter
Kd 0 0 0
Ke 12 12 12
END
    cat >room.obj <<'END'
mtllib room.mtl
v -2 -2 -2
v 2 -2 -2
v 2 2 -2
v -2 2 -2
v -2 -2 2
v 2 -2 2
v 2 2 2
v -2 2 2
v -0.5 1.99 -0.5
v 0.5 1.99 -0.5
v 0.5 1.99 0.5
v -0.5 1.99 0.5
usemtl wall
f 1 2 3 4
f 5 8 7 6
f 1 5 6 2
f 4 3 7 8
usemtl red
f 1 4 8 5
f 2 6 7 3
usemtl emitter
f 9 10 11 12
END
}
