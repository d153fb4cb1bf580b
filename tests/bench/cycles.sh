#!/bin/sh
# fovead beside Blender Cycles, mean radiance and speed: sh tests/bench/cycles.sh [OPTION...]; --help tells them.
# Ends with 1 where a mean is surely off by more than 1 %, and with 77 where there is no Blender: apt-get install blender.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
command -v blender >/dev/null || { echo "cycles: skipped: blender is not here" >&2; exit 77; }
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
trap 'exit 130' INT TERM
blender -b --factory-startup --python-exit-code 1 -P "$here/cycles.py" -- "$place" "$@" 3>&1 >/dev/null
