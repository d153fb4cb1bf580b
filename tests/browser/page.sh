#!/bin/sh
# page.sh PROGRAMS SOURCE: the page in a real browser (page.mjs), with what npm has for it.
set -eu
programs=$1 source=$2
skip() { echo "skipped: $*"; exit 77; }
command -v node >/dev/null && command -v npm >/dev/null || skip "node and npm are not here"
[ -x /usr/bin/chromium ] || skip "apt-get install chromium"
place=$programs/tests/browser
mkdir -p "$place"
cp "$source/tests/browser/package.json" "$source/tests/browser/page.mjs" "$place"
cd "$place"
[ -d node_modules ] || npm install --no-audit --no-fund --silent || skip "npm has not brought playwright-core and iwer"
node page.mjs "$programs/fovead" "$programs/foveactl" "$source"
