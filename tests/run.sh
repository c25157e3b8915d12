#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sets up a fresh Debian 12, builds and runs every test. Arguments go to ctest.
set -euo pipefail
cd "$(dirname "$0")/.."

tests/packages.sh
cmake --preset release
cmake --build --preset release
ctest --preset release -j "$(nproc)" "$@"
