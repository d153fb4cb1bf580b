#!/bin/sh
# foveactl gaze info, convert and plot: gaze.sh FOVEACTL SOURCE_DIR. Tests small logs of the corpus, the shipped
# recording, and what is refused. Each refusal is one line on stderr and a status that is not 0.
set -eu
ctl=$1
corpus=$2/tests/fuzz/corpus/log
hall=$2/fixtures/hall.gaze
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

fail() { printf 'gaze.sh: %s\n' "$*" >&2; exit 1; }
has() { grep -q -e "$1" "$dir/out" || { cat "$dir/out" >&2; fail "the output does not contain '$1'"; }; }
refused() {
    want=$1
    shift
    if "$ctl" gaze "$@" >"$dir/out" 2>"$dir/err"; then fail "accepted: $*"; fi
    [ "$(wc -l <"$dir/err")" = 1 ] || { cat "$dir/err" >&2; fail "not one line: $*"; }
    grep -q -e "$want" "$dir/err" || { cat "$dir/err" >&2; fail "no '$want': $*"; }
}

# The unit tests read every format. Here are one with a head pose, one with a screen, and one with lines of JSON in
# gzip.
for name in salient360_dynamic.csv eyelink_bino.asc glasses3.gz; do
    log=$corpus/$name
    "$ctl" gaze info "$log" >"$dir/out"
    has '^  samples      5 in 0.0'
    has '80.0 % (1 lost)'
    "$ctl" gaze convert --replace "$log" "$dir/x.gaze" >"$dir/out"
    "$ctl" gaze convert --replace "$dir/x.gaze" "$dir/x_physio.tsv.gz" >"$dir/out"
    "$ctl" gaze info "$dir/x_physio.tsv.gz" >"$dir/out"
    has 'BIDS eye tracking'
    has '80.0 % (1 lost)'
    has 'yaw -10.0 to 10.0, pitch -5.0 to 10.0 degrees'
done

# Converting a log of the project's own format gives the same file.
"$ctl" gaze convert "$hall" "$dir/hall.gaze" >"$dir/out"
cmp "$hall" "$dir/hall.gaze"

"$ctl" gaze info --json "$hall" >"$dir/out"
has '"samples": 2400'
has '"head": 2400'
has '"fixations": [1-9]'
has '"blinks": 4'
"$ctl" gaze info --screen 90 "$corpus/gazepoint.csv" >"$dir/out"
has 'yaw -23.8 to 23.8'
"$ctl" gaze info --screen 0.52,0.65 --frame RUF "$corpus/gazepoint.csv" >"$dir/out"
has 'pitch -10.0 to 5.0'
"$ctl" gaze info --time-unit ms --format glasses3 "$corpus/glasses3.gz" >"$dir/out"
has '5 in 0.000 s'

refused 'No such file' info "$dir/none"
refused 'unknown header' info "$2/LICENSE"
refused 'usage: foveactl gaze info LOG' info
refused "no command 'gaze'" fly "$hall"
refused 'unknown log format' info --format x "$hall"
refused 'fixed frame' info --frame RUF "$hall"
refused 'frame .RU.' info --frame RU "$corpus/pico.tsv"
refused 'time unit .h.' info --time-unit h "$corpus/pico.tsv"
refused '--screen wants' info --screen 0,1 "$corpus/gazepoint.csv"
refused 'does not go with gaze convert' convert --json "$hall" "$dir/x.gaze"
refused 'ends with .gaze' convert "$hall" "$dir/x.csv"
refused 'No such file' convert "$hall" "$dir/none/x.gaze"
refused 'ends with .svg or .png' plot "$hall" "$dir/x.pdf"

mkdir "$dir/bin"
ln -s "$(command -v sh)" "$dir/bin/sh"
if env PATH="$dir/bin" "$ctl" gaze plot "$hall" "$dir/x.svg" 2>"$dir/err"; then fail "it drew without gnuplot"; fi
[ "$(cat "$dir/err")" = "foveactl: gnuplot is missing: apt-get install gnuplot-nox" ] || fail "not one line on the missing gnuplot"
if ! command -v gnuplot >/dev/null; then
    echo "gaze.sh: no gnuplot here, plots are not tested"
    exit 0
fi
refused 'No such file' plot "$hall" "$dir/none/x.svg"
"$ctl" gaze plot "$hall" "$dir/it's.svg" >"$dir/out"
cp "$dir/it's.svg" "$dir/out"
has '<svg'
has 'fixation'
has 'saccade'
has 'yaw, degrees to the right'
"$ctl" gaze plot "$corpus/eyelink_2000.asc" "$dir/x.png" >"$dir/out"
has 'spread evenly'
[ "$(dd if="$dir/x.png" bs=1 skip=1 count=3 2>/dev/null)" = PNG ] || fail "no PNG"
