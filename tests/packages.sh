#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what a build needs on Debian 12; does nothing where all of it is there.
set -euo pipefail

packages=(
  cmake ninja-build g++ ccache pkg-config python3
  libcgal-dev libopenmesh-dev libdraco-dev libtinygltf-dev libglm-dev libtbb-dev libboost-dev
  libvulkan-dev mesa-vulkan-drivers vulkan-validationlayers glslang-tools libspirv-cross-c-shared-dev
  libcli11-dev libspdlog-dev nlohmann-json3-dev libxxhash-dev libspng-dev libstb-dev fonts-dejavu-core libgtest-dev
  libembree-dev libmeshoptimizer-dev libpugixml-dev libminizip-dev libmd-dev libcurl4-openssl-dev libcpp-httplib-dev chromium
)
# Whoever has npm, from wherever, has node too.
command -v npm >/dev/null || packages+=(nodejs npm)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

root=()
[ "$(id -u)" -eq 0 ] || root=(sudo)
echo "installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${root[@]}" apt-get -qq update
"${root[@]}" apt-get -qq install -y --no-install-recommends "${missing[@]}" >/dev/null
