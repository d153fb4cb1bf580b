#!/bin/sh
# The first of the README's two commands, in a copy of the tree: the pictures that it promises are there and show
# something.
set -eu
programs=$1 tree=$2
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
for entry in CMakeLists.txt daemon fixtures protocol renderer tests tracker; do cp -r "$tree/$entry" "$copy/$entry"; done
sh "$copy/daemon/demo.sh"
"$programs/e2e_picture" "$copy/out/panorama.exr" 4096 2048
for made in preview.png panorama.png samples.png summary.json; do
    [ -s "$copy/out/$made" ] || { echo "the demonstration left no out/$made" >&2; exit 1; }
done
