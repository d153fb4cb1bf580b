#!/bin/sh
# house.sh TREE: who includes whom, held against the design's storeys, where the design is beside the tree.
tool=$1/../shared/tools/house.py
[ -f "$tool" ] || { echo "skipped: the design is not here: $tool"; exit 77; }
exec python3 "$tool" "$1"
