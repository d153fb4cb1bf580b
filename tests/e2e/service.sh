#!/bin/sh
# The systemd unit for a user's own daemon: where it is installed, what it starts, and what the service may not do.
. "$(dirname "$0")/common.sh"

# The prefix contains a percent sign and a space, which systemd needs quoted.
prefix="$place/100% own"
cmake --install "$programs" --prefix "$prefix" >/dev/null
unit="$prefix/share/systemd/user/fovead.service"
[ -f "$unit" ] || fail "no unit is installed: $(find "$prefix" -name '*.service')"
if grep '@' "$unit" | grep -v -e '@system-service'; then fail "the unit still contains a placeholder"; fi
start=$(sed -n 's/^ExecStart="\(.*\)" \$FOVEAD_OPTIONS$/\1/p' "$unit" | sed 's/%%/%/g')
[ "$start" = "$prefix/bin/fovead" ] && "$start" --version >/dev/null || fail "the unit starts '$start'"
grep -q '^Type=notify$' "$unit" || fail "the unit does not wait until fovead is ready"

command -v systemd-analyze >/dev/null || { echo "skipped: no systemd-analyze, so the unit is not verified"; exit 77; }
export HOME="$place"
systemd-analyze --user verify "$unit" 2>verify.err || fail "systemd rejects the unit: $(cat verify.err)"
if grep fovead.service verify.err; then fail "systemd complains about the unit"; fi
# An exposure of 0 means that the service can do nothing, and 100 that it can do everything. The threshold is not lower
# because a user's service cannot run as another user, and needs the network and devices.
systemd-analyze --user security --offline=yes --threshold=30 "$unit" >security.txt 2>&1 ||
    fail "the service may do too much: $(grep '^✗' security.txt)"
