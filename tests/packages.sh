#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs Debian 12's packages for a purpose, or several: build (and run) the binary, tests, checks of the source.
# Does nothing where all are there. Usage: tests/packages.sh build|tests|checks...
set -euo pipefail

build=(
  cmake ninja-build g++ ccache pkg-config
  libcgal-dev libopenmesh-dev libdraco-dev libtinygltf-dev libtinyobjloader-dev libglm-dev libtbb-dev libboost-dev libembree-dev
  libmeshoptimizer-dev libpugixml-dev libspirv-cross-c-shared-dev libvulkan-dev mesa-vulkan-drivers
  vulkan-validationlayers glslang-tools
  libcli11-dev libspdlog-dev nlohmann-json3-dev libxxhash-dev libspng-dev libturbojpeg0-dev libwebp-dev libstb-dev
  libminizip-dev zlib1g-dev libzstd-dev libmd-dev libproj-dev libcurl4-openssl-dev libcpp-httplib-dev fonts-dejavu-core
)
tests=(python3 libgtest-dev chromium)
# Whoever has npm, from wherever, has node too.
command -v npm >/dev/null || tests+=(nodejs npm)
checks=(git clang-14 clang-format-14 clang-tidy-14)

wanted=()
for purpose in "${@:-none}"; do
  case $purpose in
    build | tests | checks) declare -n list=$purpose && wanted+=("${list[@]}") ;;
    *) echo "usage: tests/packages.sh build|tests|checks..." >&2 && exit 2 ;;
  esac
done
missing=()
for package in "${wanted[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

root=()
[ "$(id -u)" -eq 0 ] || root=(sudo)
echo "installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${root[@]}" apt-get -qq update
"${root[@]}" apt-get -qq install -y --no-install-recommends "${missing[@]}" >/dev/null
