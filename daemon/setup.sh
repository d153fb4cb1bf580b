#!/bin/sh
# Installs missing packages that fovead is built from: sh daemon/setup.sh. With those that tests need, and gnuplot, with
# which foveactl and fovea-bench draw charts: sh daemon/setup.sh tests. For Debian 12, 13 and systems with the same
# package names; as root, or by sudo if that asks for no password.
set -eu

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: %s\n' "$*" >&2; exit 1; }

case ${1:-} in
'') tests= ;;
tests) tests="busybox-static cpio gnuplot-nox libcmocka-dev libumockdev-dev openssl protobuf-compiler python3-protobuf python3-zstandard
        qemu-system-x86 umockdev xz-utils"
    # The page is tested where npm is there, whose packages would be too many for that alone.
    ! command -v npm >/dev/null || tests="$tests chromium" ;;
*) die "usage: sh daemon/setup.sh [tests]" ;;
esac
packages="gcc g++ cmake ninja-build pkg-config protobuf-c-compiler libassimp-dev libcglm-dev libembree-dev libhidapi-dev
    libjansson-dev libjpeg62-turbo-dev libopenimageio-dev libprotobuf-c-dev libssl-dev libusb-1.0-0-dev
    libwebsockets-dev libzstd-dev zlib1g-dev $tests"

command -v dpkg-query >/dev/null || die "there is no dpkg here: install by hand what these Debian packages hold:" $packages
missing=
for package in $packages; do
    # pkg-config may be there as pkgconf, and other packages may stand for one: what is provided counts.
    dpkg-query -W -f '${db:Status-Status} ${Package}, ${Provides}\n' 2>/dev/null |
        grep -Eq "^installed (.*[ ,])?$(printf %s "$package" | sed 's/[+.]/\\&/g')([ ,(:]|$)" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" != 0 ]; then
    sudo -n true 2>/dev/null || die "missing; as root: apt-get install --no-install-recommends$missing"
    as_root=sudo
fi
say "installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing >"$log" 2>&1 </dev/null
}
# Package lists may be absent, or too old to be of use.
install || { $as_root apt-get update -q >"$log" 2>&1 && install; } || {
    grep '^E:' "$log" >&2 || tail -n 3 "$log" >&2
    die "apt-get could not install$missing"
}
