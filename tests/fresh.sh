#!/bin/sh
# Test the two commands on a bare machine: debootstrap makes a minimal Debian root, and in a clone of this tree there
# `sh daemon/demo.sh` and then `sh tests/run.sh` are run. Needs root. Mirror, keyring and apt's settings are those of
# this machine. The pictures of the demonstration are left in out/fresh/.
set -eu
cd "$(dirname "$0")/.."
tree=$PWD

say() { printf 'fresh: %s\n' "$*"; }
die() { printf 'fresh: %s\n' "$*" >&2; exit 1; }

usage="usage: sh tests/fresh.sh [bookworm|trixie]
bookworm is Debian 12, trixie Debian 13; without a name the one that this machine runs, and bookworm elsewhere"
[ $# -le 1 ] || die "$usage"
case ${1:-$(. /etc/os-release && echo "${VERSION_CODENAME:-}")} in
bookworm) release=bookworm number=12 ;;
trixie) release=trixie number=13 ;;
*) [ $# = 0 ] || die "$usage"; release=bookworm number=12 ;;
esac
[ "$(id -u)" = 0 ] || die "must be run as root: debootstrap and chroot need it"
command -v debootstrap >/dev/null || apt-get install -y --no-install-recommends debootstrap >/dev/null
command -v git >/dev/null || die "git is missing: apt-get install git"
[ -z "$(git status --porcelain)" ] || say "only what is committed is tested; there are changes that are not"

# A main mirror holds all releases, so take this machine's main one, which has no suffix such as -updates.
mirror=$(apt-get indextargets --format '$(REPO_URI) $(CODENAME)' 'Created-By: Packages' |
    sed -nE 's/ (bookworm|trixie)$//p' | head -n 1)
keyring=/usr/share/keyrings/debian-archive-keyring.gpg # apt-get install debian-archive-keyring
[ -n "$mirror" ] || mirror=http://deb.debian.org/debian
root=$(mktemp -d /var/tmp/fovead-fresh.XXXXXX)
chmod 755 "$root" # like /, because tests run as other users

finish() {
    for place in proc dev/shm dev/pts dev sys; do
        mountpoint -q "$root/$place" && umount -l "$root/$place"
    done
    rm -rf --one-file-system "$root"
}
trap finish EXIT
trap 'exit 130' INT TERM

say "a minimal Debian $number ($release) from $mirror"
debootstrap --variant=minbase --keyring="$keyring" "$release" "$root" "$mirror" >"$root.log" 2>&1 ||
    { tail -n 5 "$root.log" >&2; die "debootstrap failed"; }
rm -f "$root.log"
for setting in /etc/apt/apt.conf /etc/apt/apt.conf.d/*; do
    [ -f "$setting" ] && cp "$setting" "$root/etc/apt/apt.conf.d/" || true
done
cp /etc/resolv.conf "$root/etc/resolv.conf"
echo "127.0.0.1 localhost" >"$root/etc/hosts" # the installer writes this, debootstrap does not
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
git clone -q "$tree" "$root/fovead"

inside() {
    chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 TERM=dumb sh -c "cd /fovead && $1"
}
say "sh daemon/demo.sh"
inside "sh daemon/demo.sh"
for file in preview.png panorama.png panorama.exr samples.png summary.json; do
    [ -s "$root/fovead/out/$file" ] || die "the demonstration left no out/$file"
done
mkdir -p out/fresh
cp "$root"/fovead/out/* out/fresh/
say "sh tests/run.sh"
inside "sh tests/run.sh"
say "both commands work on a fresh Debian $number"
