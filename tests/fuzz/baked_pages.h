// SPDX-License-Identifier: GPL-3.0-or-later
// Real pages to damage: a small city, baked.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "baker/bake.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/source.h"
#include "tests/fuzz/fuzz_settings.h"
#include "tests/unit/baker/test_city.h"

namespace zc::test {

struct BakedPages {
  std::vector<std::vector<std::uint32_t>> pages;
  std::uint32_t material_count = 0;
  double step_m = 0;
};

// Zones of every level and size, at most `count`, the first and the last node of the index among them.
inline Result<BakedPages> bake_pages(std::size_t count) {
  std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-fuzz-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) return Error{ErrorCode::kIo, "no temporary folder", pattern};
  const std::filesystem::path folder = pattern;
  BakeOptions options;
  options.leaf_triangles = 1200;
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
      ZC_ASSIGN(std::vector<std::uint32_t> page, load_page(*source, baked.index, id));
      out.pages.push_back(std::move(page));
    }
    return out;
  };
  Result<BakedPages> pages = load();
  std::filesystem::remove_all(folder);
  return pages;
}

}  // namespace zc::test
