# Shared by the end-to-end tests, which run as sh TEST.sh PROGRAMS SOURCE, where PROGRAMS is the build directory. Each
# test runs the real programs in a directory of its own, which is removed afterwards. Every failure says what was
# expected.
set -eu
. "$(dirname "$0")/../room.sh"
programs=$1
source=$2
fovead=$programs/fovead
foveactl=$programs/foveactl
place=$(mktemp -d)
cd "$place"
export XDG_RUNTIME_DIR="$place"
unset FOVEAD_TOKEN NOTIFY_SOCKET
daemon=

finish() {
    status=$?
    [ -z "$daemon" ] || kill -9 "$daemon" 2>/dev/null || true
    [ "$status" = 0 ] || ! [ -f daemon.err ] || sed 's/^/daemon: /' daemon.err >&2
    cd /
    rm -rf "$place"
    exit "$status"
}
trap finish EXIT

fail() {
    printf 'FAIL: %s\n' "$*" >&2
    exit 1
}

# Write the first second of the shipped recording to short.gaze.
make_log() {
    head -n 122 "$source/fixtures/hall.gaze" >short.gaze
}

# start OPTION...: start a daemon and wait until it is ready. Its output is in daemon.out and daemon.err.
start() {
    rm -f daemon.out daemon.err
    "$fovead" "$@" >daemon.out 2>daemon.err &
    daemon=$!
    await "the daemon: $*" is_ready "$@"
}
is_ready() {
    kill -0 "$daemon" 2>/dev/null || fail "the daemon did not start: $*"
    grep -qs '^fovead: ready$' daemon.out daemon.err
}

# stop [SIGNAL]: end the daemon, which must exit with 0.
stop() {
    kill "-${1:-TERM}" "$daemon"
    wait "$daemon" || fail "the daemon ended with status $?"
    daemon=
}

# refused WORD COMMAND...: the command must fail with status 1 or 2, and with one line on stderr that contains WORD.
refused() {
    word=$1
    shift
    status=0
    timeout 1200 "$@" >refused.out 2>refused.err </dev/null || status=$?
    case $status in
    1 | 2) ;;
    *) fail "status $status, where 1 or 2 was expected: $* $(cat refused.err)" ;;
    esac
    [ "$(wc -l <refused.err)" = 1 ] && [ "$(tail -c 1 refused.err | wc -l)" = 1 ] ||
        fail "not one line on stderr: $*: $(cat refused.err)"
    grep -qF -e "$word" refused.err || fail "'$word' is not in the line of $*: $(cat refused.err)"
}

# near LIMIT REFERENCE TEST [OPTION...]: the mean of FLIP, the difference that an eye sees between two pictures, must be
# at most LIMIT.
near() {
    limit=$1
    shift
    "$foveactl" compare --json "$@" >near.json || fail "no comparison: $*"
    mean=$(sed -n 's/^ *"mean": \([0-9.e-]*\),$/\1/p' near.json)
    [ -n "$mean" ] || fail "no mean in near.json: $(cat near.json)"
    awk "BEGIN {exit !($mean <= $limit)}" || fail "FLIP of $* is $mean, where at most $limit was expected"
}

# watched FILE CONDITION...: write half a second of foveactl watch to FILE, then test the condition. For await.
watched() {
    watched_file=$1
    shift
    kill -0 "$daemon" || fail 'the daemon has gone'
    "$foveactl" watch --for 0.5 --json >"$watched_file" && "$@"
}

# told FILE KEY LEAST: write foveactl stats to FILE, then test whether the number of this key is at least LEAST. For
# await.
told() {
    kill -0 "$daemon" || fail 'the daemon has gone'
    "$foveactl" stats --json >"$1" && [ "$(number "$2" "$1")" -ge "$3" ]
}

# number KEY FILE: print the whole number of this key in a JSON file.
number() {
    found=$(sed -n "s/.*\"$1\": \([0-9]*\).*/\1/p" "$2")
    [ -n "$found" ] || fail "no $1 in $2: $(cat "$2")"
    echo "$found"
}
