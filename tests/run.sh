#!/bin/sh
# Installs what is missing, builds, and runs every test: release, AddressSanitizer with UndefinedBehaviorSanitizer, and
# ThreadSanitizer for what has threads. One argument runs only that build: release, sanitize or tsan.
set -eu
cd "$(dirname "$0")/.."
sh daemon/setup.sh tests

export ASAN_OPTIONS="abort_on_error=0:detect_stack_use_after_return=1"
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="print_stacktrace=1"
# The reader of pictures forks copies, in which OpenImageIO starts threads.
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp:second_deadlock_stack=1:die_after_fork=0"

# Many tests wait for daemons more than they work.
jobs=$(($(nproc) + 1))
for build in ${1:-release sanitize tsan}; do
    sanitizers=
    label=
    case $build in
    release) ;;
    sanitize) sanitizers=address,undefined ;;
    tsan) sanitizers=thread label=threads ;;
    *) echo "run.sh: expected release, sanitize or tsan: $build" >&2; exit 2 ;;
    esac
    printf '\n== %s ==\n' "$build"
    cmake -S . -B "build/$build" -G Ninja -DSANITIZE=$sanitizers >/dev/null
    cmake --build "build/$build"
    ctest --test-dir "build/$build" --output-on-failure -j "$jobs" ${label:+-L $label}
done
