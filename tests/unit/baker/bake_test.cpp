// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bake.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "baker/scene/bake_cache.h"
#include "base/file.h"
#include "streamer/world_format/bvh_page.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

class Bake : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("zonecast-bake-test-" + std::to_string(::getpid()) + "-" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result<BakeReport> bake(Scene scene, const char* name, unsigned threads = 2, std::uint32_t leaf_triangles = 600) {
    BakeOptions options;
    options.threads = threads;
    options.leaf_triangles = leaf_triangles;
    return bake_world(std::move(scene), 0, options, folder_ / name);
  }

  fs::path folder_;
};

std::map<std::string, std::vector<std::byte>> read_world(const fs::path& world) {
  std::map<std::string, std::vector<std::byte>> out;
  for (const auto& entry : fs::recursive_directory_iterator(world)) {
    if (!entry.is_regular_file() || entry.path().filename() == kBakeReportName) continue;
    auto bytes = read_file(entry.path(), 1U << 30U);
    EXPECT_TRUE(bytes.ok());
    out[fs::relative(entry.path(), world).string()] = *std::move(bytes);
  }
  return out;
}

void expect_sound(const fs::path& world) {
  auto bytes = read_file(world / kWorldIndexName, 1U << 30U);
  ASSERT_TRUE(bytes.ok());
  auto index = decode_world_index(*bytes, "world.zcw");
  ASSERT_TRUE(index.ok()) << index.error().describe();
  std::size_t details = 0;
  for (const NodeRecord& node : index->nodes) {
    const std::string name = node_file(node, "glb");
    auto glb = read_file(world / name, 1U << 30U);
    auto zbvh = read_file(world / node_file(node, "zbvh"), 1U << 30U);
    ASSERT_TRUE(glb.ok() && zbvh.ok()) << name;
    auto mesh = decode_zone_glb(*glb, node, name);
    ASSERT_TRUE(mesh.ok()) << mesh.error().describe();
    auto bvh = decode_bvh_file(*zbvh, *mesh, node, name);
    ASSERT_TRUE(bvh.ok());
    auto page = assemble_page(*mesh, *bvh, node, index->header.material_count, name);
    ASSERT_TRUE(page.ok()) << page.error().describe();
    EXPECT_EQ(page->size() * 4, node.page_bytes);
    if (node.is_detail()) {
      ++details;
      // What rounding moved; at the lattice's own step, of cut borders alone.
      if (node.step_shift == 0) {
        EXPECT_LE(node.error_max_m, 4.0F / 256);
      }
      EXPECT_LE(node.error_max_m, 0.1F * 2 / 3);
    } else if (node.parent >= 0) {
      EXPECT_GE(index->nodes[static_cast<std::size_t>(node.parent)].error_max_m, node.error_max_m);
    }
  }
  EXPECT_GE(details, 1U);
}

TEST_F(Bake, TheSameSceneGivesTheSameBytesAtAnyThreadCount) {
  ASSERT_TRUE(bake(test::small_city(), "one", 1).ok());
  const auto one = read_world(folder_ / "one");
  EXPECT_GT(one.size(), 20U);
  for (const unsigned threads : {2U, 4U}) {
    const std::string name = std::to_string(threads);
    ASSERT_TRUE(bake(test::small_city(), name.c_str(), threads).ok());
    EXPECT_TRUE(read_world(folder_ / name) == one) << threads << " threads";
  }
}

// Raises the roof of one house: its triangles' upper points.
Scene with_one_house_raised() {
  Scene scene = test::small_city();
  const SceneObject& house = scene.objects[1 + 5 * 12 + 3];  // the ground is the first
  double top = -1e9;
  for (std::uint32_t t = house.first_triangle; t < house.first_triangle + house.triangle_count; ++t)
    for (const std::uint32_t v : scene.triangles[t]) top = std::max(top, scene.positions[v].z);
  for (std::uint32_t t = house.first_triangle; t < house.first_triangle + house.triangle_count; ++t)
    for (const std::uint32_t v : scene.triangles[t])
      if (scene.positions[v].z == top) scene.positions[v].z += 0.5;
  return scene;
}

TEST_F(Bake, ABakeAgainBuildsOnlyWhatAChangeTouchesAndGivesTheBytesOfABakeFromNothing) {
  const auto first = bake(test::small_city(), "world");
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first->proxies_reused, 0U);
  const auto before = read_world(folder_ / "world");

  const auto again = bake(test::small_city(), "world");
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->proxies_built, 0U);
  EXPECT_EQ(again->proxies_reused, first->proxies_built);
  EXPECT_TRUE(read_world(folder_ / "world") == before);

  const auto changed = bake(with_one_house_raised(), "world", 1);
  ASSERT_TRUE(changed.ok());
  // The house's leaf and those above it, of which there are at most as many as levels.
  std::uint32_t levels = 0;
  for (const NodeRecord& node : changed->index.nodes) levels = std::max(levels, node.depth + 1U);
  EXPECT_GE(changed->proxies_built, 1U);
  EXPECT_LE(changed->proxies_built, levels);
  EXPECT_GT(changed->proxies_reused, changed->proxies_built);
  ASSERT_TRUE(bake(with_one_house_raised(), "from_nothing").ok());
  EXPECT_TRUE(read_world(folder_ / "world") == read_world(folder_ / "from_nothing"));
  EXPECT_FALSE(read_world(folder_ / "world") == before);
}

TEST_F(Bake, AMaterialThatChangesIsSeenByTheZonesThatHaveIt) {
  ASSERT_TRUE(bake(test::small_city(), "world").ok());
  Scene scene = test::small_city();
  scene.materials[2].base_color.g = 0.9F;  // grass, in every zone
  const auto changed = bake(std::move(scene), "world");
  ASSERT_TRUE(changed.ok());
  EXPECT_EQ(changed->proxies_reused, 0U);
  scene = test::small_city();
  scene.materials[2].base_color.g = 0.9F;
  scene.materials.push_back({"new", {0, 0, 1}, 0.1F, 0});  // behind the others, of no triangle
  const auto longer = bake(std::move(scene), "world");
  ASSERT_TRUE(longer.ok());
  EXPECT_EQ(longer->proxies_built, 0U);
}

TEST_F(Bake, ADamagedCacheIsAsGoodAsNone) {
  ASSERT_TRUE(bake(test::small_city(), "world").ok());
  const auto sound = read_world(folder_ / "world");
  const std::vector<std::byte>& bytes = sound.at(kBakeCacheName);
  std::vector<std::vector<std::byte>> damaged = {
      {}, {bytes.begin(), bytes.begin() + 7}, {bytes.begin(), bytes.end() - 1}};
  for (const std::size_t at : {std::size_t{0}, std::size_t{4}, std::size_t{20}, std::size_t{40}, bytes.size() / 2}) {
    damaged.push_back(bytes);
    damaged.back()[at] ^= std::byte{0x10};
  }
  for (const auto& file : damaged) {
    ASSERT_TRUE(write_file(folder_ / "world" / kBakeCacheName, file).ok());
    const auto report = bake(test::small_city(), "world");
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->proxies_reused, 0U);
    EXPECT_TRUE(read_world(folder_ / "world") == sound);
  }
}

// As above, by who knows the checksum: what an entry says is held against what a proxy can be.
TEST_F(Bake, ACacheThatSaysNonsenseUnderAGoodChecksumNeverBreaksAWorld) {
  ASSERT_TRUE(bake(test::small_city(), "world").ok());
  const auto sound = read_world(folder_ / "world");
  constexpr std::size_t kHeader = 16;
  std::uint32_t seed = 9;
  for (int round = 0; round < 6; ++round) {
    std::vector<std::byte> bytes = sound.at(kBakeCacheName);
    for (int flips = 0; flips < 30; ++flips) {
      seed = seed * 1664525U + 1013904223U;
      bytes[kHeader + (seed >> 4U) % (bytes.size() - kHeader)] ^= std::byte(1U << (seed % 8U));
    }
    const std::uint64_t hash = XXH3_64bits(bytes.data() + kHeader, bytes.size() - kHeader);
    std::memcpy(bytes.data() + 8, &hash, sizeof hash);
    ASSERT_TRUE(write_file(folder_ / "world" / kBakeCacheName, bytes).ok());
    const auto report = bake(test::small_city(), "world");
    if (report.ok()) expect_sound(folder_ / "world");
  }
}

TEST_F(Bake, EveryPageAssemblesAndErrorsNeverRiseOnRefinement) {
  auto report = bake(test::small_city(), "world");
  ASSERT_TRUE(report.ok()) << report.error().describe();
  expect_sound(folder_ / "world");
  EXPECT_LE(report->index.nodes[0].triangle_count, 600U);
  EXPECT_EQ(report->index.header.source_triangles, 40U * 40 * 2 + 144U * 10);
}

TEST_F(Bake, LeavesKeepTheErrorBound) {
  auto report = bake(test::small_city(), "world");
  ASSERT_TRUE(report.ok());
  const auto& nodes = report->index.nodes;
  for (const auto& node : nodes) {
    const bool is_leaf_zone = node.child_count == 1 && nodes[node.first_child].is_detail();
    if (is_leaf_zone) {
      EXPECT_LE(node.error_max_m, 0.10F);
    }
  }
}

TEST_F(Bake, TheTilesetCoversEveryNodeAndVolumesNest) {
  auto report = bake(test::small_city({5e5, 5e6, 100}), "world");
  ASSERT_TRUE(report.ok());
  std::ifstream file(folder_ / "world" / "tileset.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["asset"]["version"], "1.1");
  EXPECT_EQ(json["root"]["refine"], "REPLACE");
  EXPECT_DOUBLE_EQ(json["root"]["transform"][12], 5e5);
  EXPECT_DOUBLE_EQ(json["root"]["transform"][13], 5e6);
  std::size_t tiles = 0;
  const auto visit = [&](const auto& self, const nlohmann::json& tile, double parent_error) -> void {
    ++tiles;
    EXPECT_TRUE(fs::exists(folder_ / "world" / tile["content"]["uri"].get<std::string>()));
    const double error = tile["geometricError"];
    EXPECT_LE(error, parent_error);
    if (!tile.contains("children")) return;
    for (const auto& child : tile["children"]) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto side = [&](const nlohmann::json& t, int sign) {
          const auto& box = t["boundingVolume"]["box"];
          return box[axis].template get<double>() + sign * box[3 + 4 * axis].template get<double>();
        };
        EXPECT_GE(side(child, -1), side(tile, -1) - 1e-9);
        EXPECT_LE(side(child, +1), side(tile, +1) + 1e-9);
      }
      self(self, child, error);
    }
  };
  visit(visit, json["root"], json["geometricError"]);
  EXPECT_EQ(tiles, report->index.nodes.size());
}

TEST_F(Bake, DegenerateScenesBakeOrSayWhy) {
  EXPECT_FALSE(bake(Scene{}, "empty").ok());
  EXPECT_FALSE(fs::exists(folder_ / "empty"));

  test::SceneMaker single;
  single.triangle({1e7, 1e7, 0}, {1e7 + 3, 1e7, 0}, {1e7, 1e7 + 2, 1}, 0);
  single.object(ObjectKind::kObject);
  ASSERT_TRUE(bake(std::move(single.scene), "single").ok());
  expect_sound(folder_ / "single");

  test::SceneMaker heap;
  for (int i = 0; i < 3000; ++i) heap.triangle({0, 0, 0}, {1 + i * 0.004, 0, 1}, {0, 1, i * 0.004}, 0);
  heap.object(ObjectKind::kObject);
  ASSERT_TRUE(bake(std::move(heap.scene), "heap", 2, 100).ok());
  expect_sound(folder_ / "heap");

  test::SceneMaker sliver;
  sliver.triangle({0, 0, 0}, {4e6, 0, 0}, {2e6, 0.004, 0}, 0);
  sliver.object(ObjectKind::kObject);
  EXPECT_FALSE(bake(std::move(sliver.scene), "sliver").ok());
}

TEST_F(Bake, OneBuildingOfManyTrianglesBakes) {
  test::SceneMaker maker;
  const int n = 120;  // 2 n² triangles on a bumpy dome
  const auto at = [&](int x, int y) {
    return glm::dvec3(
        x * 0.5, y * 0.5,
        20 * std::sin(x * M_PI / n) * std::sin(y * M_PI / n) + 0.3 * std::sin(x * 1.7) * std::sin(y * 2.3));
  };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) maker.quad(at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), 0);
  maker.object(ObjectKind::kObject);
  auto report = bake(std::move(maker.scene), "dome", 2, 2000);
  ASSERT_TRUE(report.ok());
  expect_sound(folder_ / "dome");
  EXPECT_LE(report->index.nodes[0].triangle_count, 2000U);
  EXPECT_GT(report->index.nodes.size(), 5U);
}

TEST_F(Bake, AnOldWorldIsReplacedWholeAndOtherFoldersAreLeftAlone) {
  ASSERT_TRUE(bake(test::small_city(), "world").ok());
  test::SceneMaker single;
  single.triangle({0, 0, 0}, {3, 0, 0}, {0, 2, 1}, 0);
  single.object(ObjectKind::kObject);
  ASSERT_TRUE(bake(single.scene, "world").ok());
  EXPECT_EQ(read_world(folder_ / "world").size(), 3U + 4U);
  // A failing bake leaves the world.
  EXPECT_FALSE(bake(Scene{}, "world").ok());
  EXPECT_EQ(read_world(folder_ / "world").size(), 3U + 4U);

  fs::create_directories(folder_ / "photos");
  std::ofstream(folder_ / "photos" / "a.jpg") << "x";
  auto refused = bake(single.scene, "photos");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kArgument);
  EXPECT_TRUE(fs::exists(folder_ / "photos" / "a.jpg"));
  // Nothing temporary stays behind.
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_)) ++entries;
  EXPECT_EQ(entries, 2U);
}

// A closed box in a closed box: nobody sees it, and its world is the one without it.
TEST_F(Bake, ExteriorLeavesOutWhatNobodySees) {
  const auto world = [&](bool inner, bool exterior, const char* name) {
    test::SceneMaker maker;
    maker.terrain({0, 0, 0}, 24, 5);
    const auto closed = [&](const glm::dvec3& low, const glm::dvec3& high) {
      maker.box(low, high);
      maker.quad({low.x, high.y, low.z}, {high.x, high.y, low.z}, {high.x, low.y, low.z}, low, 0);
      maker.object(ObjectKind::kObject);
    };
    closed({40, 40, 5}, {60, 60, 30});
    if (inner) closed({45, 45, 10}, {50, 50, 20});
    BakeOptions options;
    options.exterior = exterior;
    options.reuse = false;
    const auto baked = bake_world(std::move(maker.scene), 0, options, folder_ / name);
    EXPECT_TRUE(baked.ok());
    EXPECT_EQ(baked->interior_faces, inner && exterior ? 12U : 0U);
    EXPECT_EQ(baked->left_out.front().count == 12, inner && exterior);
    auto files = read_world(folder_ / name);
    EXPECT_EQ(files.erase(kWorldIndexName), 1U);  // counts the source's triangles
    return files;
  };
  const auto bare = world(false, false, "bare");
  EXPECT_NE(world(true, false, "full"), bare);
  EXPECT_EQ(world(true, true, "dropped"), bare);
  EXPECT_EQ(world(false, true, "nothing to drop"), bare);
}

}  // namespace
}  // namespace zc
