#!/bin/sh
# The installed client library as other projects use it: header, pkg-config file, shared and static linking.
# protocol_install.sh CMAKE BUILD LIBDIR CC SANITIZERS
set -eu
cmake=$1 build=$2 libdir=$3 cc=$4 sanitizers=$5
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
"$cmake" --install "$build" --component client --prefix "$root" >/dev/null
test -f "$root/share/fovea/fovea.proto"

cat >"$root/client.c" <<'C'
#include <fovea/protocol.h>
#include <stdio.h>
int main(void)
{
    struct pro_address address = {.is_unix = true, .path = "/nowhere/at.all"};
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char error[PRO_ERROR_SIZE];
    if (pro_connect(&address, &hello, 1000, false, error)) return 1;
    puts(error);
    return 0;
}
C
export PKG_CONFIG_PATH="$root/$libdir/pkgconfig"
expected='nothing listens at unix:/nowhere/at.all: No such file or directory'
flags=${sanitizers:+-fsanitize=$sanitizers}

"$cc" $flags "$root/client.c" -o "$root/shared" $(pkg-config --cflags --libs fovea)
test "$(LD_LIBRARY_PATH="$root/$libdir" "$root/shared")" = "$expected"

# Link the static library. The libraries that it needs are shared.
rm "$root/$libdir"/libfovea.so*
"$cc" $flags "$root/client.c" -o "$root/static" $(pkg-config --static --cflags --libs fovea)
test "$("$root/static")" = "$expected"
