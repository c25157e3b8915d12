#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Whether clang-format would change a C++ file; headers that shaders share are among them.
set -euo pipefail
cd "$(dirname "$0")/.."

tests/packages.sh checks
find base baker streamer runtime shaders replay tests \( -name '*.cpp' -o -name '*.h' \) -print0 |
  xargs -0 -n 50 -P "$(nproc)" clang-format-14 --dry-run --Werror
