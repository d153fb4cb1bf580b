#!/bin/sh
# Who may connect: tokens and how fast they can be guessed, owners of sockets, and what a client beyond the limit is told.
. "$(dirname "$0")/common.sh"
make_room
small="--scene room.obj --size 256x128 --gaze synthetic:2"
port=$("$programs/e2e_port")
local=tcp:127.0.0.1:$port

# Without a token loopback is open, with one it is asked for there too, and never on a Unix socket.
start $small --listen "$local"
"$foveactl" --connect "$local" stats >/dev/null || fail "loopback is closed without a token"
stop
export FOVEAD_TOKEN=sesame-opens
start $small --listen "$local" --listen "unix:$place/own"
unset FOVEAD_TOKEN
"$foveactl" --connect "unix:$place/own" stats >/dev/null || fail "a Unix socket asks for a token"
refused 'no token: set FOVEAD_TOKEN' "$foveactl" --connect "$local" stats
FOVEAD_TOKEN=sesame-opens "$foveactl" --connect "$local" stats >/dev/null || fail "the token does not open"

# Guessing is slow: tokens from one address are checked one per second, and a right one waits for its turn.
began=$(date +%s%N)
for guess in sesame sesame-open sesame-opens- Sesame-opens; do
    FOVEAD_TOKEN=$guess refused 'token is wrong' "$foveactl" --connect "$local" stats
done
FOVEAD_TOKEN=sesame-opens "$foveactl" --connect "$local" stats >/dev/null || fail "the token does not open after wrong ones"
took=$((($(date +%s%N) - began) / 1000000))
[ "$took" -ge 4000 ] || fail "four wrong tokens and the right one took $took ms, where 4000 at least were expected"
# Not by many at once either; some are not looked at at all. Others are served meanwhile.
guessers=
for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16; do
    FOVEAD_TOKEN=guess-$i "$foveactl" --connect "$local" stats >guess.$i.out 2>guess.$i.err &
    guessers="$guessers $!"
done
"$foveactl" --connect "unix:$place/own" stats >/dev/null || fail "a client that needs no token is not served"
for guesser in $guessers; do if wait "$guesser"; then fail "a guess opened: $(cat guess.*.out)"; fi; done
cat guess.*.err >guesses
[ "$(grep -c 'token is wrong\|too many wrong tokens\|shown no token' guesses)" = 16 ] || fail "$(cat guesses)"
FOVEAD_TOKEN=sesame-opens "$foveactl" --connect "$local" stats >/dev/null || fail "the token does not open after guesses"
# Nothing that is said, or that other users can see of a process, holds a token.
if grep -q -e sesame -e guess- daemon.out daemon.err guesses refused.err; then fail "a token was printed"; fi
if tr '\0' '\n' <"/proc/$daemon/cmdline" | grep -q sesame; then fail "the token is an argument"; fi

# The client too many is told why; the daemon and the others go on.
for place_of in "unix:$place/own" "$local"; do
    FOVEAD_TOKEN=sesame-opens "$programs/e2e_hostile" "$place_of" crowd || fail "a crowd at $place_of"
    is_empty() { "$foveactl" --connect "unix:$place/own" stats >stats.txt && grep -q '^clients   1$' stats.txt; }
    await 'room for other clients' is_empty
done
# Who shows no token does not take everybody's room.
"$programs/e2e_hostile" "$local" strangers 2>strangers.err || fail "silent strangers: $(cat strangers.err)"
grep -q 'turned away: 64 clients are connected' daemon.err || fail "$(cat daemon.err)"
stop

# The default socket is in no folder where others can put one.
mkdir shared
chmod 1777 shared
XDG_RUNTIME_DIR=$place/shared refused "nobody else can write to" "$fovead" $small
XDG_RUNTIME_DIR=$place/shared refused "nobody else can write to" "$foveactl" stats
XDG_RUNTIME_DIR=$place/shared "$foveactl" --help >/dev/null || fail "no help without a socket"
[ -z "$(ls shared)" ] || fail "something is left in a folder of others: $(ls shared)"
# One that is named may be anywhere: who listens there is looked at.
start $small --listen "unix:$place/shared/socket"
"$foveactl" --connect "unix:$place/shared/socket" stats >/dev/null
stop
[ -z "$(ls shared)" ] || fail "something is left in a folder of others: $(ls shared)"
