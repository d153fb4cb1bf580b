#!/bin/sh
# Run every command of the README as a new user would, in a copy of the tree and with a new home. The two commands of
# the whole project are left out: the demonstration has a test of its own, and the test suite runs this test.
set -eu
programs=$1 tree=$2
home=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$home"' EXIT
mkdir "$home/tree" "$home/run"
for entry in CMakeLists.txt daemon fixtures protocol renderer tests tracker; do ln -s "$tree/$entry" "$home/tree/$entry"; done
mkdir -p "$home/tree/build"
ln -s "$programs" "$home/tree/build/release"
cd "$home/tree"
export HOME="$home" XDG_RUNTIME_DIR="$home/run"
unset FOVEAD_TOKEN

# The README's commands: everything between ```sh and ```. The first one that fails ends the test.
{
    echo 'set -eux'
    sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$tree/README.md" | grep -v -e '^sh daemon/demo.sh' -e '^sh tests/'
} >"$home/commands.sh"
[ "$(wc -l <"$home/commands.sh")" -gt 20 ] || { echo "the README's commands were not found" >&2; exit 1; }
bash "$home/commands.sh"

for made in view.png panorama.jpg panorama.exr samples.png own.exr final.exr final.jpg difference.png replay.exr piano.png; do
    [ -s "$made" ] || { echo "the README's commands left no $made" >&2; exit 1; }
done
