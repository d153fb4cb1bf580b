#!/bin/bash
# Listeners for browsers that speak TLS (--tls): the page and WebSocket are served as without it, to clients that speak TLS
# alone; and whatever is wrong with the certificate or the key is told in one line at the start.
. "$(dirname "$0")/common.sh"
command -v openssl >/dev/null || { echo 'skipped: apt-get install openssl'; exit 77; }
trap '' PIPE # a write to a connection that fovead has closed fails, and no more
make_room
port=$("$programs/e2e_port")
raw=$("$programs/e2e_port")

# make NAME [ISSUER]: NAME.pem, a certificate, and NAME.key, its key, signed by itself or by an issuer.
make() {
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj "/CN=$1" -days 2 -keyout "$1.key" -out "$1.pem" \
        ${2:+-CA "$2.pem" -CAkey "$2.key"} 2>openssl.err || fail "$(cat openssl.err)"
}
make root
make middle root
make leaf middle
cat leaf.pem middle.pem >chain.pem
start --scene room.obj --size 256x128 --gaze synthetic:1 --listen "http:127.0.0.1:$port" --listen "tcp:127.0.0.1:$raw" --tls chain.pem,leaf.key
grep -q "^listens  https:127.0.0.1:$port$" daemon.out && grep -q "^page     https://127.0.0.1:$port/$" daemon.out || fail "the addresses: $(cat daemon.out)"
grep -q "^listens  tcp:127.0.0.1:$raw$" daemon.out || fail "the address without TLS: $(cat daemon.out)"

# talk OPTION...: what is answered to stdin until the daemon ends the connection. The client has root.pem alone, so that it
# needs the certificates between that and the daemon's.
talk() { openssl s_client -quiet -connect "127.0.0.1:$port" -CAfile root.pem -verify_return_error "$@" 2>talk.err; }
host="Host: 127.0.0.1:$port\r\n"
end="Connection: close\r\n\r\n"
ask() {
    printf "$1" | talk >answer || true
    head -n 1 answer | grep -q "^HTTP/1.1 $2 " || fail "expected $2 of $1: $(head -c 300 answer; cat talk.err)"
}
ask "GET / HTTP/1.1\r\n$host$end" 200
sed '1,/^\r*$/d' answer | cmp - "$source/protocol/web/index.html" || fail 'the page is not what is in the tree'
ask "GET / HTTP/1.1\r\nHost: evil.example\r\n$end" 403

# Messages over WebSocket: Hello is answered with Welcome.
key="Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: fovea\r\n\r\n"
exec 3> >(talk >welcome)
talker=$!
printf "GET / HTTP/1.1\r\n${host}Origin: https://127.0.0.1:$port\r\n$key"'\x82\x84\0\0\0\0\x0a\2\x8\1' >&3
is_welcome() { grep -aq 'fovead [0-9]' welcome; }
await 'Welcome over TLS' is_welcome
head -n 1 welcome | grep -q ' 101 ' || fail "$(head -n 1 welcome)"
for origin in "http://127.0.0.1:$port" https://evil.example "https://127.0.0.1:$((port + 1))"; do
    printf "GET / HTTP/1.1\r\n${host}Origin: $origin\r\n$key" | talk >answer || true
    ! head -n 1 answer | grep -q ' 101 ' || fail "a page of $origin comes in"
done
grep -q "turned away: it asks as a page of another site does, 'http://127.0.0.1:$port'" daemon.err || fail "$(cat daemon.err)"

# HTTP without TLS, and other nonsense, ends that connection alone. Whatever server name is asked for, it is the same server,
# and always HTTP/1.1.
for bytes in "GET / HTTP/1.1\r\n$host$end" '\x16\x03\x01\xff\xff' '\x16\x03\x01\0\5\1\0\0\1\0' '\x82\x84\0\0\0\0\x0a\2\x8\1'; do
    exec 4<>"/dev/tcp/127.0.0.1/$port" || fail 'no connection'
    printf "$bytes" >&4 2>/dev/null || true
    case $bytes in
    *ff) ;; # waits for what never comes
    *)
        cat <&4 >answer 2>/dev/null || true
        ! grep -aq 'HTTP\|fovead' answer || fail "answered without TLS: $(head -c 100 answer)"
        ;;
    esac
    exec 4>&-
done
for name in raw files web :raw :files evil.example; do
    printf "GET / HTTP/1.1\r\n$host$end" | talk -servername "$name" >answer || true
    head -n 1 answer | grep -q ' 200 ' || fail "not served as $name: $(head -c 300 answer; cat talk.err)"
done
printf "GET / HTTP/1.1\r\n$host$end" | openssl s_client -ign_eof -connect "127.0.0.1:$port" -alpn h2,http/1.1 >answer 2>&1 || true
grep -q '^ALPN protocol: http/1.1' answer && grep -q '^HTTP/1.1 200 ' answer || fail "HTTP/2: $(cat answer)"

# A listener without TLS stays as it is, and sees the one client by WebSocket. That goes on until it ends.
"$foveactl" --connect "tcp:127.0.0.1:$raw" stats --json >stats.json || fail 'the listener without TLS'
sees() { "$foveactl" --connect "tcp:127.0.0.1:$raw" stats --json >stats.json && [ "$(number clients stats.json)" = "$1" ]; }
await 'two clients' sees 2
exec 3>&-
kill "$talker"
await 'one client' sees 1
stop
! grep -v '^fovead: client [0-9]* (.*) turned away: ' daemon.err || fail 'other lines'

# What is wrong with the files, or with the command line.
listen="--scene room.obj --listen http:127.0.0.1:$port"
no() {
    words=$1
    shift
    # shellcheck disable=SC2086
    refused "$words" "$fovead" $listen --tls "$@"
}
no 'none.pem: No such file' none.pem,leaf.key
no 'none.key: No such file' leaf.pem,none.key
no 'there is no certificate in it' leaf.key,leaf.key
cp leaf.pem private.pem
chmod 600 private.pem
no 'there is no key in it' leaf.pem,private.pem
no 'there is no certificate in it' room.obj,leaf.key
no 'no regular file' .,leaf.key
no 'no regular file' leaf.pem,.
mkfifo pipe
no 'pipe: it is no regular file' pipe,leaf.key
no 'no regular file' /dev/zero,leaf.key
no 'root.key: it is not the key of the certificate in leaf.pem' leaf.pem,root.key
: >empty
chmod 600 empty
no 'there is no certificate in it' empty,leaf.key
no 'there is no key in it' leaf.pem,empty
openssl ec -in leaf.key -aes128 -passout pass:sesame -out locked.key 2>openssl.err || fail "$(cat openssl.err)"
chmod 600 locked.key
no 'its key has a passphrase' leaf.pem,locked.key
sed '3s/.*/AAAA/' leaf.pem >broken.pem
no 'its certificate cannot be read' broken.pem,leaf.key
cat leaf.pem broken.pem >broken_chain.pem
no 'its certificate number 2 cannot be read' broken_chain.pem,leaf.key
sed '2s/.*/AAAA/' leaf.key >broken.key
chmod 600 broken.key
no 'its key cannot be read' leaf.pem,broken.key
truncate -s 2M large.pem
no 'a PEM file of at most' large.pem,leaf.key
cp leaf.key open.key
chmod 644 open.key
no 'others can read or change this key, of mode 644: chmod 6' leaf.pem,open.key
for pair in leaf.pem leaf.pem, ,leaf.key leaf.pem,leaf.key,root.pem ,; do no 'wants two PEM files' "$pair"; done
refused '--tls needs --listen http:' "$fovead" --scene room.obj --tls leaf.pem,leaf.key
refused '--tls needs --listen http:' "$fovead" --scene room.obj --listen "tcp:127.0.0.1:$port" --tls leaf.pem,leaf.key
refused 'give it as http:' "$fovead" --scene room.obj --listen "https:127.0.0.1:$port" --tls leaf.pem,leaf.key
