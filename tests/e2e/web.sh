#!/bin/bash
# Listeners for browsers. Over HTTP they serve the page's files, and nothing else, and only if the Host and Origin headers of
# a request are those of the page. Over WebSocket they serve clients: a client that sends nonsense is dropped with a line that
# says why, and an honest client goes on.
. "$(dirname "$0")/common.sh"
trap '' PIPE # a write to a connection that fovead has closed fails, and no more
make_room
port=$("$programs/e2e_port")
start --scene room.obj --size 512x256 --gaze synthetic:1 --listen "http:127.0.0.1:$port" --listen "unix:$place/fovead.sock"
grep -q "^page     http://127.0.0.1:$port/$" daemon.out || fail "no address of the page: $(cat daemon.out)"

# ask REQUEST: what is answered until the daemon ends the connection; \r\n are written as in printf.
ask() {
    exec 3<>"/dev/tcp/127.0.0.1/$port" || fail "no connection"
    printf "$1" >&3
    cat <&3 >answer
    exec 3>&-
}
# speak FRAMES [FILE]: the answer to these frames, and the bytes of the file behind them, once WebSocket is agreed on.
speak() {
    exec 3<>"/dev/tcp/127.0.0.1/$port" || fail "no connection"
    printf "GET / HTTP/1.1\r\n${host}Origin: http://127.0.0.1:$port\r\n$key" >&3
    while IFS= read -r line <&3 && [ "$line" != $'\r' ]; do echo "$line"; done >answer
    answered 101
    { printf "$1"; cat "${2:-/dev/null}"; } >&3 2>/dev/null || true
    cat <&3 >answer || true
    exec 3>&-
}
host="Host: 127.0.0.1:$port\r\n"
end="Connection: close\r\n\r\n"
# answered STATUS: the answer begins so.
answered() { head -n 1 answer | grep -q "^HTTP/1.[01] $1 " || fail "expected $1: $(head -c 300 answer)"; }

# The page's files, whole and of their kind; nothing beside them.
for file in "$source"/protocol/web/*; do
    name=$(basename "$file")
    [ "$name" != index.html ] || name=
    ask "GET /$name HTTP/1.1\r\n$host$end"
    answered 200
    case $file in
    *.html) kind=text/html ;;
    *.js) kind=text/javascript ;;
    *.css) kind=text/css ;;
    *.svg) kind=image/svg+xml ;;
    esac
    tr -d '\r' <answer >text
    grep -qi "^content-type: $kind$" text && grep -qi "^content-security-policy: default-src 'none'" text || fail "headers of $name: $(head -n 9 text)"
    sed '1,/^\r*$/d' answer | cmp - "$file" || fail "$name is not what is in the tree"
done
for path in /index.html /none /../fovead /%%2e%%2e/etc/passwd //; do
    ask "GET $path HTTP/1.1\r\n$host$end"
    ! head -n 1 answer | grep -q ' 200 ' || cmp -s <(sed '1,/^\r*$/d' answer) "$source/protocol/web/index.html" || fail "$path is served"
done
ask "POST / HTTP/1.1\r\n${host}Content-Length: 0\r\n$end"
answered 405
ask "GET / HTTP/1.1\r\nHost: localhost:1\r\n$end" # by adb reverse, say
answered 200
ask "GET / HTTP/1.1\r\nHost: [::1]:$port\r\n$end"
answered 200

# A page of another site, whose name may have been made to lead here. Only this machine can connect to this listener, by the
# names above, so that the machine's own name is none of them.
own=$(uname -n)
[ "$own" != localhost ] || fail 'this test needs a machine with a name'
for site in evil.example "evil.example:$port" 127.0.0.1.evil.example localhost.evil.example "$own:$port"; do
    ask "GET / HTTP/1.1\r\nHost: $site\r\n$end"
    answered 403
    grep -q "turned away: it asks for the host '$site', which is no name of this listener$" daemon.err || fail "nothing is said of $site"
done
for request in "GET / HTTP/1.1\r\n$end" "GET / HTTP/1.0\r\n\r\n"; do
    ask "$request"
    answered 403
done
[ "$(grep -c 'turned away: its request has no Host header$' daemon.err)" = 2 ] || fail "nothing is said of what is missing: $(cat daemon.err)"
long=$(printf '%300s' '' | tr ' ' a)
ask "GET / HTTP/1.1\r\nHost: $long\r\n$end"
answered 403
grep -q 'turned away: its Host or Origin header has 256 bytes or more$' daemon.err || fail "nothing is said of a long name: $(cat daemon.err)"
key="Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: fovea\r\n\r\n"
for origin in http://evil.example "https://127.0.0.1:$port" "http://127.0.0.1:$((port + 1))" null "http://127.0.0.1:$port.evil.example"; do
    ask "GET / HTTP/1.1\r\n${host}Origin: $origin\r\n$key"
    ! head -n 1 answer | grep -q ' 101 ' || fail "a page of $origin comes in"
    grep -q "turned away: it asks as a page of another site does, '$origin'$" daemon.err || fail "nothing is said of $origin: $(cat daemon.err)"
done

# Messages: a masked frame of 0 makes the mask of no effect. Text, nonsense, and a message before Hello.
for case in 'text:\x81\x82\0\0\0\0hi' 'not a message:\x82\x82\0\0\0\0\x3a\5' 'did not say hello first:\x82\x84\0\0\0\0\x3a\2\x8\5' 'no known body:\x82\x83\0\0\0\0\xf8\3\1'; do
    speak "${case#*:}"
    grep -aq "${case%%:*}" answer || fail "it is not told '${case%%:*}'"
    grep -q "dropped: .*${case%%:*}" daemon.err || fail "nothing is said of '${case%%:*}': $(cat daemon.err)"
done
# Hello in two fragments, with a version that is none; and a message longer than any may be.
speak '\x02\x82\0\0\0\0\x0a\2\x80\x82\0\0\0\0\x8\x9'
grep -aq 'it speaks version 9' answer || fail "fragments are not put together: $(tail -n 2 daemon.err)"
head -c 65537 /dev/zero >long
speak '\x82\xff\0\0\0\0\0\1\0\1\0\0\0\0' long
grep -q 'dropped: it sent a message that is too long' daemon.err || fail "a message without end: $(tail -n 2 daemon.err)"

# What is no HTTP, headers without end, and connections that come and go.
ask "nonsense\r\n\r\n"
{
    printf 'GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: '
    head -c 100000 /dev/zero | tr '\0' x
} >long
exec 3<>"/dev/tcp/127.0.0.1/$port"
cat long >&3 2>/dev/null || true
cat <&3 >/dev/null || true
exec 3>&-
# Requests that no page makes, each more often than there are places; none of them may keep a place.
odd() {
    for i in $(seq 70); do
        exec 3<>"/dev/tcp/127.0.0.1/$port" || fail "connection $i is refused"
        printf "$1" >&3 2>/dev/null || true
        exec 3>&-
    done
}
plain="Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
for name in raw files web r ''; do
    odd "GET / HTTP/1.1\r\nHost: $name\r\n\r\n"
    odd "GET / HTTP/1.1\r\nHost: $name\r\n${plain}Sec-WebSocket-Protocol: raw\r\n\r\n"
    odd "GET / HTTP/1.1\r\nHost: $name\r\n${plain}Sec-WebSocket-Protocol: signal\r\n\r\n"
done
odd "GET / HTTP/1.1\r\n$host$plain\r\n"
odd "CONNECT host:80 HTTP/1.1\r\n$host\r\n"
odd "GET / HTTP/1.1\r\n${host}Upgrade: h2c\r\nConnection: Upgrade, HTTP2-Settings\r\nHTTP2-Settings: AAMAAABkAAQAAP__\r\n\r\n"
serves() { ask "GET / HTTP/1.1\r\n$host$end" && head -n 1 answer | grep -q ' 200 '; }
await 'a place for an honest browser' serves
# A WebSocket without the protocol's name is none of ours, whoever asks.
ask "GET / HTTP/1.1\r\n${host}Origin: http://evil.example\r\n$plain\r\n"
! head -n 1 answer | grep -q ' 101 ' || fail 'a WebSocket without a protocol comes in'
for i in $(seq 200); do
    exec 3<>"/dev/tcp/127.0.0.1/$port" || fail "connection $i is refused"
    exec 3>&-
done
are_gone() { "$foveactl" stats --json >stats.json && [ "$(number clients stats.json)" = 1 ]; }
await 'all of them to be gone' are_gone
"$foveactl" watch --for 1 --json >watch.json || fail "the honest client"
# A connection that has asked for nothing yet does not disturb the end.
exec 3<>"/dev/tcp/127.0.0.1/$port"
sleep 0.3
stop
exec 3>&-
! grep -v '^fovead: \(client \([0-9]* \)\?(.*) \(dropped\|turned away\)\|libwebsockets\): ' daemon.err || fail 'other lines'

# Where other machines can connect, this machine is asked for by its addresses and its own names, and by no others.
FOVEAD_TOKEN=sesame-opens start --scene room.obj --size 256x128 --gaze synthetic:1 --listen "http:0.0.0.0:$port" --listen "unix:$place/fovead.sock"
grep -q "^page     http://$own:$port/#token=TOKEN " daemon.out || fail "no address of the page: $(cat daemon.out)"
for name in 127.0.0.1 192.0.2.7 "[2001:db8::7]" localhost "$own" "${own%%.*}" "${own%%.*}.local" "$(echo "${own%%.*}" | tr a-z A-Z).LOCAL"; do
    ask "GET / HTTP/1.1\r\nHost: $name:$port\r\n$end"
    answered 200
done
for name in evil.example "$own.evil.example" "evil.$own" "${own%%.*}.localx" "${own%?}" "evil.${own%%.*}.local" local .local; do
    ask "GET / HTTP/1.1\r\nHost: $name:$port\r\n$end"
    answered 403
done

# Who has loaded the page keeps connections for some seconds. These are no clients, however many there are: a client comes in.
load() {
    for i in $(seq "$1"); do
        exec {place_of}<>"/dev/tcp/127.0.0.1/$port" || fail "connection $i is refused"
        printf "GET / HTTP/1.1\r\n$host\r\n" >&"$place_of"
        while IFS= read -r line <&"$place_of" && [ "$line" != $'\r' ]; do echo "$line"; done >answer
        answered 200
        open="$open $place_of"
    done
}
# welcomed: a browser's client that has the token is welcome.
welcomed() {
    exec 3<>"/dev/tcp/127.0.0.1/$port" || fail 'no connection'
    printf "GET / HTTP/1.1\r\n${host}Origin: http://127.0.0.1:$port\r\n$key"'\x82\x92\0\0\0\0\x0a\x10\x8\1\x3a\xcsesame-opens' >&3
    part=
    until case $part in *'fovead '[0-9]) true ;; *) false ;; esac; do
        LC_ALL=C IFS= read -r -d '' -n 1 byte <&3 || fail "not welcome: $part"
        part=$part$byte
    done
    exec 3>&-
}
open=
load 100
welcomed
# WebSockets that say nothing are strangers, and the rest of the room is for others.
is_crowded() {
    for i in $(seq 20); do
        exec {place_of}<>"/dev/tcp/127.0.0.1/$port" || fail "connection $i is refused"
        printf "GET / HTTP/1.1\r\n${host}Origin: http://127.0.0.1:$port\r\n$key" >&"$place_of"
        open="$open $place_of"
    done
    grep -q 'turned away: 16 clients of this listener have shown no token' daemon.err
}
await 'strangers to be turned away' is_crowded
"$foveactl" stats --json >stats.json || fail 'no room for a client of another listener'
for place_of in $open; do exec {place_of}>&-; done
await 'all of them to be gone' are_gone
stop

# Browsers alone connect there; a token is asked for where others could come.
refused 'browsers connect there' "$foveactl" --connect "http:127.0.0.1:$port" stats
refused FOVEAD_TOKEN "$fovead" --scene room.obj --listen "http:0.0.0.0:$port"
