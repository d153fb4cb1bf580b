#!/bin/sh
# Compares fovead with Blender Cycles in mean radiance and speed: sh tests/bench/cycles.sh [OPTION...]; --help lists the
# options. Exit code 1: a mean is certainly off by more than 1 %. Exit code 77: there is no Blender (apt-get install blender).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
command -v blender >/dev/null || { echo "cycles: skipped: blender is not installed" >&2; exit 77; }
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
trap 'exit 130' INT TERM
blender -b --factory-startup --python-exit-code 1 -P "$here/cycles.py" -- "$place" "$@" 3>&1 >/dev/null
