#!/bin/sh
# page.sh PROGRAMS SOURCE [SCRIPT [ARGUMENT...]]: runs page.mjs, or another script that lies here, with what npm has for it.
set -eu
programs=$(cd "$1" && pwd) source=$(cd "$2" && pwd) script=${3:-page.mjs}
[ $# -lt 3 ] || shift
shift 2
skip() { echo "skipped: $*"; exit 77; }
command -v node >/dev/null && command -v npm >/dev/null || skip "node and npm are not here"
[ -x /usr/bin/chromium ] || skip "apt-get install chromium"
place=$programs/tests/browser
mkdir -p "$place"
cp "$source/tests/browser/package.json" "$source"/tests/browser/*.mjs "$place"
cd "$place"
[ -d node_modules ] || npm install --no-audit --no-fund --silent || skip "npm has not brought playwright-core and iwer"
node "$script" "$programs/fovead" "$programs/foveactl" "$source" "$@"
