# fovead with a real kernel: sh vm.sh PROGRAMS SOURCE, where PROGRAMS is the build directory. QEMU (without KVM, one
# processor) boots Debian's kernel. The guest mounts the host's files read-only, runs fovead from PROGRAMS, and makes
# eye trackers through uhid and vhci_hcd. The kernel's package is downloaded once, into FOVEAD_VM_CACHE or
# ~/.cache/fovead-vm. Exit code 77: this machine cannot run the test, and a line says why.
set -eu
programs=$(realpath "$1")
source=$(realpath "$2")
cache=${FOVEAD_VM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/fovead-vm}

skip() {
    echo "skipped: $*"
    exit 77
}
for tool in qemu-system-x86_64:qemu-system-x86 cpio:cpio xz:xz-utils objcopy:binutils dpkg:dpkg; do
    command -v "${tool%%:*}" >/dev/null || skip "${tool%%:*} is missing (apt-get install ${tool#*:})"
done
busybox=$(command -v busybox || true)
[ -n "$busybox" ] && ! ldd "$busybox" >/dev/null 2>&1 || skip "a static busybox is missing (apt-get install busybox-static)"
[ "$(uname -m)" = x86_64 ] || skip "the guest's kernel is for x86_64"

# Ask for the package by its exact name and version, because apt takes a shorter name for a pattern.
name=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/.*Depends: \(linux-image-[0-9][^ ]*\)$/\1/p' | head -n 1)
version=$(apt-cache policy "${name:-none}" 2>/dev/null | sed -n 's/.*Candidate: //p')
release=${name#linux-image-}
mkdir -p "$cache"
if ! [ -f "$cache/release" ] || { [ -n "$version" ] && [ "$(cat "$cache/release")" != "$release" ]; }; then
    [ -n "$version" ] || skip "no kernel package is known here (apt-get update)"
    work=$(mktemp -d "$cache/fetch.XXXXXX")
    (
        cd "$work"
        apt-get download "$name=$version" >/dev/null 2>&1 || exit 1
        modules=./lib/modules/$release/kernel
        dpkg --fsys-tarfile "$name"_*.deb | tar -x --wildcards "./boot/vmlinuz-$release" "$modules/drivers/hid/*" \
            "$modules/drivers/usb/*" "$modules/drivers/virtio/*" "$modules/fs/9p/*" "$modules/net/9p/*" "$modules/fs/netfs/*" \
            "$modules/fs/fscache/*" 2>/dev/null || true
        # vmlinuz contains vmlinux as an xz stream. QEMU can boot vmlinux directly, which saves the guest the unpacking.
        start=$(LC_ALL=C grep -abo "$(printf '\3757zXZ')" "boot/vmlinuz-$release" | head -n 1 | cut -d: -f1)
        tail -c +$((start + 1)) "boot/vmlinuz-$release" | xz -dc --single-stream >vmlinux 2>/dev/null || true
        head -c 4 vmlinux | grep -q ELF || exit 1
        rm -rf "$cache/modules"
        mv "$modules" "$cache/modules"
        mv vmlinux "$cache/vmlinux"
        echo "$release" >"$cache/release"
    ) || { rm -rf "$work"; skip "the kernel's package could not be fetched or unpacked"; }
    rm -rf "$work"
fi

place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
root=$place/root
mkdir -p "$root/bin" "$root/modules" "$root/proc" "$root/sys" "$root/dev" "$root/host"
cp "$busybox" "$root/bin/busybox"
for applet in sh mount insmod cat echo mkdir chroot dd printf poweroff; do ln -s busybox "$root/bin/$applet"; done

# with_needs MODULE: print the file of a module after the files of the modules that it depends on.
with_needs() {
    file=$(find "$cache/modules" -name "$(echo "$1" | tr _ -).ko" -o -name "$(echo "$1" | tr - _).ko" | head -n 1)
    [ -n "$file" ] || return 0 # built in
    for need in $(objcopy -O binary -j .modinfo "$file" /dev/stdout | tr '\0' '\n' | sed -n 's/^depends=//p' | tr , ' '); do
        (with_needs "$need")
    done
    echo "$file"
}
for module in virtio_pci 9pnet_virtio 9p uhid hid_generic usbhid vhci_hcd; do with_needs "$module"; done | awk '!seen[$0]++' >"$place/modules"
while read -r file; do
    cp "$file" "$root/modules/"
    basename "$file" >>"$root/modules/order"
done <"$place/modules"

cat >"$root/init" <<END
#!/bin/sh
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
while read -r module; do insmod "/modules/\$module"; done </modules/order
mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=262144 host /host
mount -t tmpfs -o mode=755 run /host/run
mount -o bind /proc /host/proc
mount -o bind /sys /host/sys
mount -o bind /dev /host/dev
chroot /host /bin/sh $source/tests/device/vm_guest.sh $programs
code=\$?
echo "guest: exit code \$code"
printf "\\\\x\$(printf %02x \$code)" | dd of=/dev/port bs=1 seek=244 2>/dev/null
poweroff -f
END
chmod 755 "$root/init"
(cd "$root" && find . | cpio -o -H newc --quiet) >"$place/initramfs"

# The byte that the guest writes to port 0xf4 ends QEMU with the exit code 2 * byte + 1.
status=0
qemu-system-x86_64 -M pc -accel tcg -smp 1 -m 1024 -nodefaults -no-user-config -display none -no-reboot \
    -kernel "$cache/vmlinux" -initrd "$place/initramfs" -serial stdio -device isa-debug-exit,iobase=0xf4,iosize=1 \
    -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap \
    -append "console=ttyS0 quiet panic=-1 mitigations=off nokaslr" </dev/null || status=$?
[ $((status % 2)) = 1 ] || { echo "FAIL: the guest ended without an exit code"; exit 1; }
exit $((status / 2))
