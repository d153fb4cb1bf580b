#!/bin/sh
# Installs what is missing, builds, and runs every test: release, AddressSanitizer with UndefinedBehaviorSanitizer, and
# ThreadSanitizer for what has threads. One argument runs only that preset: release, sanitize or tsan.
set -eu
cd "$(dirname "$0")/.."
sh daemon/setup.sh tests

# Everything is stopped after its own time limit; the halves of a broken run are never left behind.
export ASAN_OPTIONS="abort_on_error=0:detect_stack_use_after_return=1"
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="print_stacktrace=1"
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp:second_deadlock_stack=1"

# Many tests wait for daemons more than they work.
jobs=$(($(nproc) + 1))
for preset in ${1:-release sanitize tsan}; do
    printf '\n== %s ==\n' "$preset"
    cmake --preset "$preset" -G Ninja >/dev/null
    cmake --build "build/$preset"
    case $preset in
    tsan) ctest --test-dir "build/$preset" --output-on-failure -j "$jobs" -L threads ;;
    *) ctest --test-dir "build/$preset" --output-on-failure -j "$jobs" ;;
    esac
done
