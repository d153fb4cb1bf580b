#!/bin/sh
# The systemd unit for a user's own daemon: where it is installed, what it starts, and what that may not do.
. "$(dirname "$0")/common.sh"

# Quotes and per cent signs are systemd's own.
prefix="$place/100% own"
cmake --install "$programs" --prefix "$prefix" >/dev/null
unit="$prefix/share/systemd/user/fovead.service"
[ -f "$unit" ] || fail "no unit is installed: $(find "$prefix" -name '*.service')"
if grep '@' "$unit" | grep -v -e '@system-service'; then fail "something was left to fill in"; fi
start=$(sed -n 's/^ExecStart="\(.*\)" \$FOVEAD_OPTIONS$/\1/p' "$unit" | sed 's/%%/%/g')
[ "$start" = "$prefix/bin/fovead" ] && "$start" --version >/dev/null || fail "the unit starts '$start'"
grep -q '^Type=notify$' "$unit" || fail "fovead tells when it is ready; the unit does not wait for that"

command -v systemd-analyze >/dev/null || { echo "no systemd-analyze: what the unit says is not looked at"; exit 77; }
export HOME="$place"
systemd-analyze --user verify "$unit" 2>verify.err || fail "not a good unit: $(cat verify.err)"
if grep fovead.service verify.err; then fail "not a good unit"; fi
# 0 is a service that can do nothing, 10 one that can do anything; a user's own cannot be told to be somebody else, and
# needs the network and devices.
systemd-analyze --user security --offline=yes --threshold=30 "$unit" >security.txt 2>&1 ||
    fail "it may do too much: $(grep '^✗' security.txt)"
