#!/bin/sh
# Run the table of tests/cases/gaze: gaze_cases.sh FOVEACTL SOURCE_DIR. Prints every row with another result than
# expected.
set -eu
ctl=$1
cd "$2/tests/cases/gaze"
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
name=none status=0 count=0 bad=0

wrong() {
    printf 'gaze_cases.sh: %s: %s\n' "$name" "$*" >&2
    cat "$dir/out" "$dir/err" >&2
    bad=$((bad + 1))
}
has() { [ "$status" = 0 ] && grep -q -E -e "$1" "$dir/out" || wrong "no '$1'"; }

while read -r verb rest; do
    case $verb in
    '' | '#'*) ;;
    case)
        name=$rest
        count=$((count + 1))
        status=0
        # A row's arguments contain no blanks.
        "$ctl" gaze $rest >"$dir/out" 2>"$dir/err" </dev/null || status=$?
        ;;
    six)
        has 'samples +6 in '
        has '\(1 lost\)'
        has 'yaw -(8\.0|8\.1|7\.9) to (10\.0|10\.1|9\.9), pitch -(5\.0|5\.1|4\.9) to (10\.0|10\.1|9\.9) degrees'
        ;;
    five)
        has 'samples +5 in '
        has '\(0 lost\)'
        has 'yaw -4\.0 to 4\.0, pitch -4\.0 to 4\.0 degrees'
        ;;
    has) has "$rest" ;;
    lacks) if grep -q -E -e "$rest" "$dir/out"; then wrong "'$rest'"; fi ;;
    refused)
        if [ "$status" = 0 ] || [ "$(wc -l <"$dir/err")" != 1 ] || ! grep -q -E -e "$rest" "$dir/err"; then
            wrong "not refused with '$rest'"
        fi
        ;;
    *) wrong "unknown word $verb" ;;
    esac
done <cases.txt

# --- cases that need more than one command --------------------------------------------------------------------

name='output over input'
cases=$PWD
fresh() { rm -rf "$dir/t" && mkdir "$dir/t"; }
run() {
    status=0
    "$ctl" gaze "$@" >"$dir/out" 2>"$dir/err" || status=$?
}
# refused RE COMMAND...: the command must fail with one line that matches RE.
refused() {
    want=$1
    shift
    run "$@"
    if [ "$status" = 0 ] || [ "$(wc -l <"$dir/err")" != 1 ] || ! grep -q -E -e "$want" "$dir/err"; then
        wrong "not refused with '$want': $*"
    fi
}
same() { cmp -s "$1" "$2" || wrong "$2 was changed"; }

fresh
cp own_comment.gaze "$dir/t/a.gaze"
ln -s a.gaze "$dir/t/l.gaze"
ln "$dir/t/a.gaze" "$dir/t/h.gaze"
ln -s . "$dir/t/folder"
refused 'is the log itself' convert "$dir/t/a.gaze" "$dir/t/a.gaze"
refused 'is the log itself' convert --replace "$dir/t/a.gaze" "$dir/t/a.gaze"
refused 'is the log itself' convert --replace "$dir/t/l.gaze" "$dir/t/a.gaze"
refused 'is the log itself' convert --replace "$dir/t/a.gaze" "$dir/t/l.gaze"
refused 'is the log itself' convert --replace "$dir/t/a.gaze" "$dir/t/h.gaze"
refused 'is the log itself' convert --replace "$dir/t/a.gaze" "$dir/t/folder/./folder/a.gaze"
cd "$dir/t"
refused 'is the log itself' convert a.gaze ./a.gaze
refused 'is the log itself' convert "$dir/t/a.gaze" a.gaze
cd "$cases"
same own_comment.gaze "$dir/t/a.gaze"
[ -L "$dir/t/l.gaze" ] || wrong "l.gaze is no longer a symbolic link"

fresh
cp bids_pixels_physio.* "$dir/t"
refused 'is the log itself' convert --replace "$dir/t/bids_pixels_physio.tsv.gz" "$dir/t/bids_pixels_physio.tsv.gz"
same bids_pixels_physio.tsv.gz "$dir/t/bids_pixels_physio.tsv.gz"
same bids_pixels_physio.json "$dir/t/bids_pixels_physio.json"
# The sidecar is an input too, and so are sidecars in folders above.
cp bids_pixels_physio.tsv.gz "$dir/t/x_physio.tsv.gz"
cp bids_pixels_physio.json "$dir/t/x_physio.json"
ln -s x_physio.json "$dir/t/y_physio.json"
refused 'was read with' convert --replace "$dir/t/x_physio.tsv.gz" "$dir/t/y_physio.tsv.gz"
same bids_pixels_physio.json "$dir/t/x_physio.json"
cp -r bids_inherited "$dir/t"
refused 'was read with' convert --replace \
    "$dir/t/bids_inherited/sub-01/beh/sub-01_task-view_run-01_recording-eye1_physio.tsv.gz" \
    "$dir/t/bids_inherited/task-view_physio.tsv.gz"
same bids_inherited/task-view_physio.json "$dir/t/bids_inherited/task-view_physio.json"
cp neon_good.csv "$dir/t/a.svg"
refused 'is the log itself' plot "$dir/t/a.svg" "$dir/t/a.svg"
same neon_good.csv "$dir/t/a.svg"

name='output over another file'
echo keep >"$dir/t/old.gaze"
refused 'old.gaze: exists.*--replace' convert neon_good.csv "$dir/t/old.gaze"
[ "$(cat "$dir/t/old.gaze")" = keep ] || wrong "old.gaze was changed"
run convert --replace neon_good.csv "$dir/t/old.gaze"
run info "$dir/t/old.gaze"
has 'samples +6 in 0.025 s'
echo keep >"$dir/t/z_physio.json"
refused 'z_physio.json: exists.*--replace' convert neon_good.csv "$dir/t/z_physio.tsv.gz"
[ ! -e "$dir/t/z_physio.tsv.gz" ] || wrong "the table was written without its sidecar"
run convert --replace neon_good.csv "$dir/t/z_physio.tsv.gz"
has '6 samples'

# exported FILE EYE RATE: convert FILE to BIDS and check what the sidecar says.
exported() {
    name="export of $1"
    fresh
    run convert "$1" "$dir/t/e_physio.tsv.gz"
    cat "$dir/t/e_physio.json" >>"$dir/out"
    has "\"RecordedEye\": \"$2\""
    has "\"SamplingFrequency\": $3"
}
exported eyelink_left_blocks.asc left '(250\.0,|249\.9|250\.[01])'
exported bids_pixels_physio.tsv.gz left 500
exported pupil_core_right_eye_only.csv right '(120\.0,|119\.9|120\.0)'
exported neon_uneven_steps.csv cyclopean '1(18|19|20|21)'
exported sranipal_8_9_ms.csv cyclopean 120

name='recordings in convert'
fresh
run convert --recording Recording2 tobii_two_recordings.tsv "$dir/t/a.gaze"
has '5 samples of Tobii Pro Lab'
refused '--recording' convert tobii_two_recordings.tsv "$dir/t/b.gaze"

name='standard input'
run info - <neon_good.csv
has 'samples +6 in 0.025 s'
for stdin in - /dev/stdin; do
    status=0
    cat neon_good.csv | "$ctl" gaze info "$stdin" >"$dir/out" 2>"$dir/err" || status=$?
    if [ "$status" = 0 ] || ! grep -q 'pipe (write it to a file first' "$dir/err"; then wrong "a pipe as $stdin"; fi
done

# The data for gnuplot: a line must not continue across a pause.
name='plot across pauses'
fresh
mkdir "$dir/bin"
printf '#!/bin/sh\ncat >"%s/plot"\n' "$dir" >"$dir/bin/gnuplot"
chmod +x "$dir/bin/gnuplot"
: >"$dir/t/p.svg"
PATH=$dir/bin:$PATH "$ctl" gaze plot eyelink_left_blocks.asc "$dir/t/p.svg" >"$dir/out" 2>"$dir/err" || true
awk '/^\$path/ { on = 1; next } /^EOD/ { on = 0 } !on { next }
    NF == 0 { apart = 1; next }
    { if (rows++ && !apart && $1 - last > 0.1) bad++; if ($1 - last > 0.1) gaps++; last = $1; apart = 0 }
    END { exit !(rows == 30 && gaps == 2 && bad == 0) }' "$dir/plot" || wrong "lines continue across pauses"

printf '%d cases, %d wrong\n' "$count" "$bad"
[ "$count" -gt 70 ] && [ "$bad" = 0 ]
