// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/left_out.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zc {
namespace {

// A proxy with an atlas, normals of ten triangles and light; and a detail that has none of it.
WorldIndex make_index() {
  NodeRecord proxy;
  proxy.triangle_count = 100;
  proxy.reference_count = 110;
  proxy.appearance_bytes = 80;
  proxy.light_bytes = 8 * 110;
  proxy.normal_bytes = 8 * 10;
  proxy.texture_bytes = 32 * 32 / 2 + 16 * 16 / 2 + 8 * 8 / 2;
  proxy.page_bytes = 4000 + proxy.texture_bytes;
  NodeRecord detail;
  detail.flags = kNodeDetail;
  detail.triangle_count = 200;
  detail.reference_count = 200;
  detail.page_bytes = 3000;
  WorldIndex index;
  index.nodes = {proxy, detail};
  return index;
}

const LeftOut* find(const std::vector<LeftOut>& all, const char* word) {
  const auto found =
      std::ranges::find_if(all, [&](const LeftOut& l) { return l.what.find(word) != std::string::npos; });
  return found == all.end() ? nullptr : &*found;
}

TEST(LeftOut, IsCountedWithWhatItSaves) {
  DiskParts proxies, detail;
  proxies.mesh = 500;
  proxies.bvh.light = 300;
  proxies.bvh.texture = 1'000'000;
  detail.mesh = 1000;
  detail.json = 1'000'000;
  const LeftOutInput input = {20, 3, 50, true, {64, 32}};
  const auto all = count_left_out(make_index(), proxies, detail, input);
  ASSERT_EQ(all.size(), 6U);

  const LeftOut* faces = find(all, "nowhere outside");
  EXPECT_EQ(faces->count, 20U);
  EXPECT_EQ(faces->page_bytes, 300U);  // a tenth of the detail
  EXPECT_EQ(faces->disk_bytes, 100U);
  const LeftOut* levels = find(all, "levels");
  EXPECT_EQ(levels->count, 3U);
  EXPECT_EQ(levels->page_bytes, 2000U);  // half of the proxies
  EXPECT_EQ(levels->disk_bytes, 400U);
  const LeftOut* normals = find(all, "normals");
  EXPECT_EQ(normals->count, 300U);
  EXPECT_EQ(normals->page_bytes, 2400U);
  const LeftOut* texcoords = find(all, "coordinates");
  EXPECT_EQ(texcoords->count, 310U);
  EXPECT_EQ(texcoords->page_bytes, 12 * 310 - 80U);
  const LeftOut* light = find(all, "light");
  EXPECT_EQ(light->count, 1U);
  EXPECT_EQ(light->page_bytes, 1600U);
  const LeftOut* atlases = find(all, "atlases");
  EXPECT_EQ(atlases->count, 2U);
  EXPECT_EQ(atlases->page_bytes, 3 * 672U + 672U);  // 64² but for 32², with their levels, and 32²
}

TEST(LeftOut, NothingIsToldOfWhatThereIsNot) {
  const auto all = count_left_out(make_index(), {}, {}, {});
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NE(find(all, "normals"), nullptr);
  EXPECT_NE(find(all, "coordinates"), nullptr);
}

}  // namespace
}  // namespace zc
