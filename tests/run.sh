#!/bin/sh
# Install what is missing, build, and run every test: a release build, one with AddressSanitizer and
# UndefinedBehaviorSanitizer, and one with ThreadSanitizer for the threaded parts. An argument runs only that build:
# release, sanitize or tsan.
set -eu
cd "$(dirname "$0")/.."
sh daemon/setup.sh tests

export ASAN_OPTIONS="abort_on_error=0:detect_stack_use_after_return=1"
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export UBSAN_OPTIONS="print_stacktrace=1"
# fovead-image forks processes in which OpenImageIO starts threads.
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp:second_deadlock_stack=1:die_after_fork=0"

# One more than there are processors, because many tests mostly wait for daemons.
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
