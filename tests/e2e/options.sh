#!/bin/sh
# Command lines: --help of both programs, which commands take which options, and exit codes: 2 for a command line that
# is refused, 1 for a failure after that.
. "$(dirname "$0")/common.sh"

# expect STATUS COMMAND...: the command must exit with STATUS. Its output is in out and err.
expect() {
    wanted=$1
    shift
    status=0
    "$@" >out 2>err </dev/null || status=$?
    [ "$status" = "$wanted" ] || fail "$* ends with status $status, expected $wanted: $(cat err)"
}

for program in "$fovead" "$foveactl"; do
    expect 0 "$program" --help
    cp out help
    [ ! -s err ] || fail "--help on stderr: $(cat err)"
    awk 'length > 120 {bad = 1; print} / $/ {bad = 1; print "a blank at the end:", $0} END {exit bad}' help || fail "--help of $program has lines that are too long or end with a blank"
    expect 0 "$program" --version
    [ "$(cat out)" = "$(basename "$program") $(sed -n 's/^project(.*VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")" ] || fail "--version: $(cat out)"
    [ "$(grep -c '^  --' help)" -gt 20 ] || fail "--help of $program names few options: $(cat help)"
    expect 2 "$program" -h
    expect 2 "$program" --nonsense
    expect 2 "$program" --=x
done

# Every option that the README uses with one of the programs is in that program's --help.
"$foveactl" --help >help
"$fovead" --help >>help
sed -n '/^```sh$/,/^```$/p' "$source/README.md" | sed 's/\\$//; s/#.*//' | grep -o 'fovea\(d\|ctl\) .*' |
    grep -o -e ' --[a-z-]*' | sort -u >used
[ "$(wc -l <used)" -gt 10 ] || fail "the README uses few options: $(cat used)"
while read -r option; do grep -q -e "$option\b" help || fail "--help does not have the README's $option"; done <used

# Every option's help begins with the commands that take it: a line without any is an option for no command.
! "$foveactl" --help | grep '^  --[^ ]* .* : ' || fail 'an option that no command takes'

# Each command with all options that it takes: it must get as far as looking for the daemon or the file.
takes() { expect 1 "$foveactl" "$@"; }
nowhere() {
    expect 1 "$foveactl" "$@" --connect "unix:$place/nowhere"
    grep -q nowhere err || fail "$*: $(cat err)"
}
nowhere watch --json --for 1 --until-finished
nowhere snapshot a.png --json --view 10,-20,90 --size 64x64 --exposure -0.5 --settle 0 --within 1
nowhere --view=gaze,60 snapshot --exposure auto a.jpg
nowhere stats --json
nowhere freeze
nowhere unfreeze
nowhere look -30,10
nowhere view -90,0,90,60 --at 0,-0.1,.5,1 --for 1
nowhere move --by -1,2,-.5 --json
nowhere save a.exr
nowhere record a.gaze --for 0.5 --replace
nowhere record --stop
nowhere recentre
nowhere recentre -1,2
log='--format fovead --time-unit ms --frame LUF --screen 0.6,0.7 --recording a'
takes samples nowhere.exr out.png --gaze nowhere.gaze
takes compare a.exr b.exr --json --ppd 20 --ldr --map c.png
# shellcheck disable=SC2086
takes gaze info nowhere.gaze $log --json
# shellcheck disable=SC2086
takes gaze convert nowhere.gaze a.gaze $log --replace
# shellcheck disable=SC2086
takes gaze plot nowhere.gaze a.svg $log

# Options that do not go with a command or with another option.
ctl_refused() {
    words=$1
    shift
    expect 2 "$foveactl" "$@"
    [ "$(cat err)" = "foveactl: $words" ] || fail "$*: $(cat err), expected: $words"
}
help='; see foveactl --help'
ctl_refused '--json does not go with freeze' freeze --json
ctl_refused '--connect does not go with compare' compare a b --connect unix:nowhere
ctl_refused '--wait does not go with gaze info' gaze info a --wait
ctl_refused '--format does not go with watch' watch --format fovead
ctl_refused '--by does not go with look' --by look 1,2
ctl_refused "--size needs --view$help" snapshot a.png --size 64x64
ctl_refused "--for does not go with --stop$help" record --stop --for 1
ctl_refused "--replace does not go with --stop$help" record --replace --stop
ctl_refused "--for wants seconds from 0 to 10000000, not '-1'$help" watch --for=-1
ctl_refused "--within wants seconds from 0 to 10000000, not '1e8'$help" snapshot a.png --within 1e8
ctl_refused "--ppd wants pixels per degree from 1 to 300, not '301'$help" compare a b --ppd 301
ctl_refused "--exposure wants stops from -64 to 64, or auto, not '65'$help" snapshot a.png --exposure 65
ctl_refused "--size wants WxH, up to 16384x16384, not '64'$help" snapshot a.png --size 64
ctl_refused "--view wants YAW,PITCH,FOV or gaze,FOV in degrees, not '1,91,60'$help" snapshot a.png --view 1,91,60
ctl_refused "--screen wants WIDTH,DISTANCE in metres, or degrees across, not '0'$help" gaze info a --screen 0
ctl_refused "--until-finished takes no value$help" watch --until-finished=1
ctl_refused "--connect needs a value$help" stats --connect
ctl_refused "--s is short for more than one option: --stop, --size, --settle, --screen$help" watch --s
ctl_refused "which command?$help" --json
ctl_refused "there is no command 'gaze'$help" gaze
ctl_refused "there is no command 'dance'$help" dance
ctl_refused 'usage: foveactl look YAW,PITCH' look
ctl_refused 'usage: foveactl look YAW,PITCH' look 1,2 3
ctl_refused 'usage: foveactl gaze convert LOG OUT' gaze convert a
