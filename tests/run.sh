#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sets up a fresh Debian 12, builds and runs every test. Arguments go to ctest. The last line counts the tests; it is an
# error when none ran.
set -euo pipefail
cd "$(dirname "$0")/.."

tests/packages.sh build tests
cmake --preset release
cmake --build --preset release
report=$PWD/build/release/tests.xml
rm -f "$report"
code=0
ctest --preset release -j "$(nproc)" --output-junit "$report" "$@" || code=$?
[ -f "$report" ] || exit "$code"  # nothing was to run: ctest's --show-only, bad arguments

count() { grep -oPm1 "\b$1=\"\K[0-9]+" "$report" | head -n 1; }
failed=$(count failures)
passed=$(($(count tests) - failed - $(count disabled) - $(count skipped)))
if [ $((passed + failed)) -eq 0 ]; then
  echo "no test ran" >&2
  code=1
fi
echo "$passed passed, $failed failed"
exit "$code"
