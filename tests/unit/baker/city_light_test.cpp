// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/city_light.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <random>

#include "base/file.h"

namespace zc {
namespace {

constexpr double kStepM = 1.0 / 256;
constexpr std::int32_t kCell = 200 * 256;  // of a leaf, in steps
constexpr int kAcross = 4;                 // leaves: a city of 800 m, so that regions are smaller than it

// A quadtree of three levels over houses on tiles of ground, the details below.
class Town {
 public:
  explicit Town(std::uint32_t seed) {
    std::mt19937 random(seed);
    add_node(-1, 0, 0, kAcross, 0);
    for (int q = 0; q < 4; ++q) add_node(0, q % 2 * 2, q / 2 * 2, 2, 1);
    for (int leaf = 0; leaf < kAcross * kAcross; ++leaf) {
      const int x = leaf % kAcross;
      const int y = leaf / kAcross;
      add_node(1 + y / 2 * 2 + x / 2, x, y, 1, 2);
    }
    const std::size_t first_leaf = 5;
    for (int leaf = 0; leaf < kAcross * kAcross; ++leaf) {
      const std::size_t n =
          add_node(static_cast<std::int32_t>(first_leaf) + leaf, leaf % kAcross, leaf / kAcross, 1, 3);
      nodes_[n].flags = kNodeDetail;
      for (int house = 0; house < 6; ++house) {
        const auto x = static_cast<std::uint16_t>(2000 + random() % 40000);
        const auto y = static_cast<std::uint16_t>(2000 + random() % 40000);
        const auto height = static_cast<std::uint16_t>(1000 + random() % 8000);
        box(meshes_[n], {x, y, 0},
            {static_cast<std::uint16_t>(x + 3000), static_cast<std::uint16_t>(y + 4000), height});
      }
      finish(n);
    }
    materials_.resize(2);
    materials_[0].base_color = {0.5F, 0.5F, 0.5F};
    materials_[1].base_color = {0.8F, 0.3F, 0.1F};
  }

  // One house of the first leaf gets one more storey.
  void raise() {
    for (auto& v : meshes_[details_first()].vertices)
      if (v[2] > 0) v[2] = static_cast<std::uint16_t>(v[2] + 700);
    finish(details_first());
  }

  // A house with details of centimetres so far to the east, on a leaf of its own.
  void add_far_house(std::int32_t east) {
    const std::size_t leaf = add_node(0, 0, 0, 1, 1);
    const std::size_t detail = add_node(static_cast<std::int32_t>(leaf), 0, 0, 1, 2);
    nodes_[detail].flags = kNodeDetail;
    box(meshes_[detail], {3000, 3000, 0}, {6000, 6000, 2000});
    for (std::uint16_t i = 0; i < 20; ++i) {
      const auto x = static_cast<std::uint16_t>(3000 + 37 * i);
      box(meshes_[detail], {x, 3000, 2000}, {static_cast<std::uint16_t>(x + 1 + i), 3004, 2009});
    }
    for (const std::size_t n : {leaf, detail}) {
      nodes_[n].origin[0] = east;
      finish(n);
    }
  }

  Result<CityLight> light(BakeCache& cache, const std::optional<SunAngles>& sun, unsigned threads = 2) const {
    std::size_t reports = 0;
    BakeContext context(threads, [&](double, std::string_view) { ++reports; });
    auto light = light_city({nodes_, sun, kStepM, cache, meshes_, materials_}, context);
    EXPECT_EQ(reports, 1 + nodes_.size());
    return light;
  }

  [[nodiscard]] std::size_t details_first() const { return 5 + kAcross * kAcross; }
  std::vector<ZoneMesh> meshes_;
  std::vector<NodeRecord> nodes_;
  std::vector<Material> materials_;

 private:
  std::size_t add_node(std::int32_t parent, int x, int y, int cells, std::uint32_t depth) {
    NodeRecord node;
    node.parent = parent;
    node.depth = static_cast<std::uint8_t>(depth);
    node.step_shift = cells == 1 ? 0 : 2;
    node.origin = {x * kCell, y * kCell, 0};
    node.error_max_m = depth == 3 ? 0.0F : 0.05F;
    ZoneMesh mesh;
    const auto width = static_cast<std::uint16_t>((cells * kCell) >> node.step_shift);
    mesh.vertices = {{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {0, width, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.materials = {0, 0};
    nodes_.push_back(node);
    meshes_.push_back(std::move(mesh));
    finish(nodes_.size() - 1);
    return nodes_.size() - 1;
  }
  void finish(std::size_t n) {
    NodeRecord& node = nodes_[n];
    node.triangle_count = static_cast<std::uint32_t>(meshes_[n].triangles.size());
    node.bounds_min = node.bounds_max = node.origin;
    for (const auto& v : meshes_[n].vertices)
      for (std::size_t axis = 0; axis < 3; ++axis)
        node.bounds_max[axis] = std::max(node.bounds_max[axis], node.origin[axis] + (v[axis] << node.step_shift));
  }
  static void box(ZoneMesh& mesh, const std::array<std::uint16_t, 3>& low, const std::array<std::uint16_t, 3>& high) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i < 8; ++i)
      mesh.vertices.push_back(
          {(i & 1U) != 0 ? high[0] : low[0], (i & 2U) != 0 ? high[1] : low[1], (i & 4U) != 0 ? high[2] : low[2]});
    for (const auto& [a, b, c, d] :
         {std::array<std::uint32_t, 4>{0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}, {4, 5, 7, 6}}) {
      mesh.triangles.push_back({first + a, first + b, first + c});
      mesh.triangles.push_back({first + a, first + c, first + d});
      mesh.materials.insert(mesh.materials.end(), 2, 1);
    }
  }
};

std::size_t different(const std::vector<gpu::TriangleLight>& a, const std::vector<gpu::TriangleLight>& b) {
  if (a.size() != b.size()) return std::max(a.size(), b.size());
  std::size_t count = 0;
  for (std::size_t t = 0; t < a.size(); ++t) count += std::memcmp(&a[t], &b[t], sizeof a[t]) != 0 ? 1 : 0;
  return count;
}

const SunAngles kLowSun{120, 12};

TEST(CityLight, RegionsSeeAllThatTheWholeCityWouldShowThem) {
  const Town town(1);
  for (const std::optional<SunAngles>& sun : {std::optional<SunAngles>(), std::optional<SunAngles>(kLowSun)}) {
    BakeCache cache;
    const auto light = town.light(cache, sun);
    ASSERT_TRUE(light.ok());
    EXPECT_EQ(light->built, town.nodes_.size());
    const auto scene = LightScene::build(town.meshes_, town.nodes_, town.materials_, kStepM, 2);
    ASSERT_TRUE(scene.ok());
    for (std::size_t n = 0; n < town.nodes_.size(); ++n)
      EXPECT_EQ(different(light->zones[n], bake_zone_light(town.meshes_[n], town.nodes_[n], *scene, sun, kStepM)), 0U)
          << "node " << n;
  }
}

// What single precision cannot separate 2,000 km from the anchor has a normal and a frame all the same.
TEST(CityLight, AHouseFarAwayChangesNoLightAndHasItsOwn) {
  const Town near(3);
  Town wide = near;
  wide.add_far_house(2'000'000 * 256);
  Town beside = near;
  beside.add_far_house(10'000 * 256);
  BakeCache cache;
  const auto of_near = near.light(cache, kLowSun);
  const auto of_wide = wide.light(cache, kLowSun);
  const auto of_beside = beside.light(cache, kLowSun);
  ASSERT_TRUE(of_near.ok() && of_wide.ok() && of_beside.ok());
  const auto sky_apart = [](const std::vector<gpu::TriangleLight>& a, const std::vector<gpu::TriangleLight>& b) {
    EXPECT_EQ(a.size(), b.size());
    double apart = 0;
    for (std::size_t t = 0; t < std::min(a.size(), b.size()); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        apart += std::abs(static_cast<double>(a[t].sky >> 8 * k & 255U) - (b[t].sky >> 8 * k & 255U)) / (255 * 3);
    return apart / static_cast<double>(std::max<std::size_t>(a.size(), 1));
  };
  for (std::size_t n = 0; n < near.nodes_.size(); ++n) {
    if (!near.nodes_[n].is_detail()) continue;
    EXPECT_LT(sky_apart(of_near->zones[n], of_wide->zones[n]), 0.01) << "node " << n;
  }
  EXPECT_LT(sky_apart(of_beside->zones.back(), of_wide->zones.back()), 0.02);
}

TEST(CityLight, AChangeIsFeltOnlyWithinReachAndGivesWhatABakeFromNothingGives) {
  Town town(2);
  BakeCache cache;
  const auto before = town.light(cache, kLowSun);
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(before->reused, 0U);
  const auto again = town.light(cache, kLowSun, 4);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->built, 0U);

  town.raise();
  const auto after = town.light(cache, kLowSun, 1);
  BakeCache empty;
  const auto fresh = town.light(empty, kLowSun);
  ASSERT_TRUE(after.ok() && fresh.ok());
  std::size_t touched = 0;
  for (std::size_t n = 0; n < town.nodes_.size(); ++n) {
    EXPECT_EQ(different(after->zones[n], fresh->zones[n]), 0U) << "node " << n;
    touched += different(after->zones[n], before->zones[n]) > 0 ? 1 : 0;
  }
  EXPECT_GE(after->built, touched);
  EXPECT_GE(touched, 2U);
  EXPECT_GT(after->reused, town.nodes_.size() / 3);

  Town repainted = town;
  repainted.materials_[1].base_color.g = 0.7F;
  const auto other = repainted.light(cache, kLowSun);
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->reused, 0U);
}

TEST(CityLight, WhatACacheCannotMeanIsBakedAnew) {
  const Town town(3);
  BakeCache cache;
  const auto sound = town.light(cache, kLowSun);
  ASSERT_TRUE(sound.ok());
  std::vector<std::byte> file = cache.encode();
  // Every byte of every entry but the keys and sizes: sizes stay, states of the sun do not.
  const auto folder = std::filesystem::temp_directory_path() / "zonecast_city_light_test";
  std::filesystem::create_directories(folder);
  for (std::size_t at = 16; at + 24 <= file.size();) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, file.data() + at + 16, sizeof bytes);
    at += 24;
    for (std::size_t i = 0; i < bytes; ++i) file[at + i] = std::byte{0xFF};
    at += bytes;
  }
  const std::uint64_t hash = XXH3_64bits(file.data() + 16, file.size() - 16);
  std::memcpy(file.data() + 8, &hash, sizeof hash);
  ASSERT_TRUE(write_file(folder / "bake.cache", file).ok());
  BakeCache damaged;
  damaged.read(folder / "bake.cache");
  std::filesystem::remove_all(folder);
  const auto light = town.light(damaged, kLowSun);
  ASSERT_TRUE(light.ok());
  EXPECT_EQ(light->reused, 0U);
}

}  // namespace
}  // namespace zc
