#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh clone on Debian 12 to pictures: sets up, builds, generates a city, bakes it, replays 120 frames of its
# drive and its still views under a memory cap, with the Vulkan validation layers on. Usage: replay/demo.sh [OUT]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/demo}

tests/packages.sh build
# A clone that tests/run.sh has set up keeps its tests.
[ -f build/release/build.ninja ] || cmake --preset release -DZONECAST_TESTS=OFF >/dev/null
cmake --build --preset release --target zonecast
zonecast=build/release/zonecast

mkdir -p "$out"
"$zonecast" generate --seed 1 --size-km 0.5 -o "$out/city"
"$zonecast" bake "$out/city/city.glb" -o "$out/world"
"$zonecast" inspect "$out/world"
echo "-- 120 frames of the drive"
"$zonecast" replay "$out/world" --path "$out/city/drive.csv" --cap 16MiB --frames 0:600:5 --size 640x360 \
  --contact-sheet --validate -o "$out/drive"
echo "-- the still views, with where each reflection came from"
"$zonecast" replay "$out/world" --path "$out/city/shots.json" --cap 16MiB --size 1280x720 \
  --contact-sheet --debug-views provenance,bvh --validate -o "$out/shots"

cat <<EOF

Look at:
  $out/drive/contact_sheet.png    twelve frames of the drive
  $out/drive/frames/              all 120
  $out/drive/stats.json           memory, streaming, rays, milliseconds
  $out/shots/contact_sheet.png    the still views
  $out/shots/provenance/          green: screen, blue: proxies, orange: coarse proxies, grey: sky
  $out/shots/bvh/                 proxies in green, the boxes of their BVH in pink
EOF
