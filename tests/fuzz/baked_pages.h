// SPDX-License-Identifier: GPL-3.0-or-later
// Real pages to damage: a small city, baked, with the files that its pages came from.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "baker/bake.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/source.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/unit/baker/test_city.h"

namespace zc::test {

struct BakedZone {
  NodeRecord record;
  std::vector<std::byte> bvh_file;
  ZoneMesh mesh;  // without materials
};

struct BakedPages {
  std::vector<std::vector<std::uint32_t>> pages;
  std::vector<BakedZone> zones;  // of pages
  std::uint32_t material_count = 0;
  double step_m = 0;
};

// Runs by hand may go on longer, and elsewhere.
inline std::uint64_t fuzz_setting(const char* variable, std::uint64_t fallback) {
  const char* text = std::getenv(variable);
  return text == nullptr ? fallback : std::strtoull(text, nullptr, 10);
}
inline std::uint64_t fuzz_seed() { return fuzz_setting("ZONECAST_FUZZ_SEED", 1); }
inline std::uint64_t fuzz_tries() { return fuzz_setting("ZONECAST_FUZZ_TRIES", 10000); }

// Zones of every level and size, at most `count`, the first and the last node of the index among them.
inline Result<BakedPages> bake_pages(std::size_t count, BvhMethod method = BvhMethod::kAuto) {
  std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-fuzz-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) return Error{ErrorCode::kIo, "no temporary folder", pattern};
  const std::filesystem::path folder = pattern;
  BakeOptions options;
  options.leaf_triangles = 1200;
  options.bvh.method = method;
  const auto load = [&]() -> Result<BakedPages> {
    ZC_ASSIGN(const BakeReport baked, bake_world(small_city(), 0, options, folder / "world"));
    ZC_ASSIGN(const std::unique_ptr<Source> source, open_directory_source(folder / "world"));
    BakedPages out;
    out.material_count = static_cast<std::uint32_t>(baked.index.materials.size());
    out.step_m = baked.index.step_m();
    const std::size_t nodes = baked.index.nodes.size();
    count = std::min(count, nodes);
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::uint32_t>(count == 1 ? 0 : i * (nodes - 1) / (count - 1));
      BakedZone zone;
      zone.record = baked.index.nodes[id];
      ZC_ASSIGN(zone.bvh_file, source->read(node_file(zone.record, "zbvh"), zone.record.bvh_bytes));
      ZC_ASSIGN(const auto glb, source->read(node_file(zone.record, "glb"), zone.record.glb_bytes));
      ZC_ASSIGN(zone.mesh, decode_zone_glb(glb, zone.record, "zone"));
      ZC_ASSIGN(std::vector<std::uint32_t> page, load_page(*source, baked.index, id));
      out.pages.push_back(std::move(page));
      out.zones.push_back(std::move(zone));
    }
    return out;
  };
  Result<BakedPages> pages = load();
  std::filesystem::remove_all(folder);
  return pages;
}

}  // namespace zc::test
