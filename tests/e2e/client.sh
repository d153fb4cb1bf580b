#!/bin/sh
# A client in any language: one in Python, made from fovea.proto alone, receives tiles and checks them.
. "$(dirname "$0")/common.sh"
make_room
python=/usr/bin/python3 # Debian's Python, which finds Debian's packages
if ! command -v protoc >/dev/null || ! "$python" -c 'import google.protobuf, zstandard' 2>/dev/null; then
    echo "skipped: apt-get install protobuf-compiler python3-protobuf python3-zstandard"
    exit 77
fi
protoc --proto_path="$source/protocol" --python_out=. fovea.proto
start --scene room.obj --size 1024 --gaze synthetic:5
"$python" "$source/tests/e2e/client.py" "$place/fovead.sock" . || fail "the client in Python"
"$python" "$source/tests/e2e/client.py" "$place/fovead.sock" . 300 || fail "the client in Python, which holds 300 pixels"
stop
