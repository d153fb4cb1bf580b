#!/bin/sh
# format.sh TREE: checks that clang-format 14 would change no C file. Other versions format differently.
clang-format --version 2>/dev/null | grep -q 'version 14\.' || { echo "skipped: clang-format 14 is not here"; exit 77; }
find "$1/daemon" "$1/fixtures" "$1/protocol" "$1/renderer" "$1/tests" "$1/tracker" -name '*.[ch]' -print0 |
    xargs -0 clang-format --dry-run -Werror
