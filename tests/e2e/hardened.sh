#!/bin/sh
# Programs that are built for users have the hardening that the compiler and linker offer.
. "$(dirname "$0")/common.sh"

cmake --install "$programs" --prefix "$place/own" >/dev/null
# is FILE WHAT PATTERN: readelf's output on the file must match.
is() { grep -qE -e "$3" readelf.out || fail "$1: no $2: $(cat readelf.out)"; }
checked=
for file in own/bin/* $(find own -name 'libfovea.so.*' -type f); do
    readelf --wide --file-header --program-headers --dynamic --dyn-syms "$file" >readelf.out
    is "$file" 'position-independent code' 'Type: +DYN '
    is "$file" 'read-only relocations' '^ *GNU_RELRO '
    is "$file" 'binding at start' 'BIND_NOW'
    is "$file" 'stack without code' '^ *GNU_STACK .* RW  '
    is "$file" 'stack protector' ' __stack_chk_fail'
    case $file in */bin/*) is "$file" 'mark of a position-independent program' 'Flags: .*PIE' ;; esac
    # Checked buffers need optimisation, and buffers that can be checked: fovead-image fills none.
    case $file in */fovead-image) ;; *)
        if grep -qE '^CMAKE_BUILD_TYPE:[A-Z]*=(|Release|RelWithDebInfo|MinSizeRel)$' "$programs/CMakeCache.txt"; then
            is "$file" 'checked buffers' ' __(snprintf|memcpy)_chk'
        fi ;;
    esac
    checked="$checked $file"
done
for file in bin/fovead bin/fovead-reader bin/fovead-image bin/foveactl bin/foveactl-image libfovea.so; do
    case $checked in *"$file"*) ;; *) fail "$file is not among what was installed: $checked" ;; esac
done
