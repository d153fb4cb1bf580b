#!/bin/sh
# house.sh TREE: checks that files include only files of their own room and of rooms below, by the design's own tool;
# skipped where that is not beside the tree.
tool=$1/../shared/tools/house.py
[ -f "$tool" ] || { echo "skipped: the design is not here: $tool"; exit 77; }
exec python3 "$tool" "$1"
