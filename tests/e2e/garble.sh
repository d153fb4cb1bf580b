#!/bin/bash
# HTTP requests, WebSocket handshakes and frames, and the beginning of TLS, changed at random from what is right.
. "$(dirname "$0")/common.sh"
make_room
port=$("$programs/e2e_port")
inputs=1000 # of each kind
for tls in '' yes; do
    pair=
    kinds='requests handshakes frames'
    if [ "$tls" ]; then
        command -v openssl >/dev/null || continue
        openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=fovead -days 2 -keyout key.pem -out cert.pem 2>openssl.err ||
            fail "$(cat openssl.err)"
        pair='--tls cert.pem,key.pem'
        kinds=tls
    fi
    # shellcheck disable=SC2086
    start --scene room.obj --size 256x128 --gaze synthetic:1 --listen "http:127.0.0.1:$port" --listen "unix:$place/fovead.sock" $pair
    for kind in $kinds; do
        "$programs/e2e_garble" "$place/fovead.sock" "$daemon" "$port" "$kind" "$inputs" || fail "$kind: $(tail daemon.err)"
    done
    stop
    ! grep -v '^fovead: \(client [0-9]* (.*) \(dropped\|turned away\)\|libwebsockets\): ' daemon.err || fail 'other lines'
done
