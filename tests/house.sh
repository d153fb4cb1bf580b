#!/bin/sh
# house.sh TREE: checks that files include only files of their own room and of rooms below, with the tool beside the
# project's design. Skipped where that is absent.
tool=$1/../shared/tools/house.py
[ -f "$tool" ] || { echo "skipped: the design is not here: $tool"; exit 77; }
exec python3 "$tool" "$1"
