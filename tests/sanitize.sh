#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of what reads untrusted bytes, under AddressSanitizer and UndefinedBehaviorSanitizer; those of what pages and
# serves from several threads, under ThreadSanitizer. Both, or the one that is named: tests/sanitize.sh [asan|tsan]
# Only what they link is built. Needs the packages of tests/packages.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

asan=(base_test streamer_test paging_memory_test golden_test draco_fuzz_test bvh_fuzz_test import_test serve_test http_test)
tsan=(streamer_test paging_memory_test serve_test http_test)

# The first finding ends a test, and fails it.
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1:check_initialization_order=1
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$PWD/tests/tsan_suppressions.txt

check() { # PRESET EXECUTABLE...
  local preset=$1
  shift
  cmake --preset "$preset" > /dev/null
  cmake --build --preset "$preset" --target "$@"
  local labels
  labels=$(IFS='|'; echo "$*")
  ctest --preset "$preset" -j "$(nproc)" --no-tests=error -L "^($labels)\$"
}

case "${1:-both}" in
  asan) check asan "${asan[@]}" ;;
  tsan) check tsan "${tsan[@]}" ;;
  both)
    check asan "${asan[@]}"
    check tsan "${tsan[@]}"
    ;;
  *)
    echo "tests/sanitize.sh: '$1' is neither asan nor tsan" >&2
    exit 2
    ;;
esac
