// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/world_tour.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "replay/compare/level_source.h"
#include "streamer/paging/heap_page_sink.h"
#include "streamer/source/index_file.h"
#include "streamer/streamer.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr test::TinyWorldOptions kShape = {.levels = 4, .detail = true};

const test::TinyWorld& world() {
  static const test::TinyWorld kWorld = test::make_tiny_world(kShape);
  return kWorld;
}

TEST(WorldBounds, AreInTheUnitsOfTheCrs) {
  const Bounds bounds = world_bounds(world().index);
  const double size = test::tiny_world_size_m(kShape);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(bounds.min[axis], test::kTinyOrigin_m, 0.01 * size);
    EXPECT_NEAR(bounds.max[axis], test::kTinyOrigin_m + size, 0.01 * size);
  }
}

TEST(Tour, LooksAtTheWorldAllTheWayAndComesCloser) {
  test::MemorySource source(world().files);
  const auto tour = tour_of(source, world().index);
  ASSERT_TRUE(tour.ok()) << tour.error().describe();
  const Bounds bounds = world_bounds(world().index);
  double time_s = -1;
  for (const CameraSample& sample : *tour) {
    EXPECT_GT(sample.time_s, time_s);
    time_s = sample.time_s;
    EXPECT_TRUE(looks_at_world(world().index, sample, 16.0 / 9).value()) << sample.time_s;
    const bool over = sample.eye.x > bounds.min.x && sample.eye.x < bounds.max.x && sample.eye.y > bounds.min.y &&
                      sample.eye.y < bounds.max.y;
    EXPECT_TRUE(!over || sample.eye.z > bounds.min.z) << sample.time_s;
  }
  EXPECT_LT(glm::length(tour->back().eye - tour->back().target),
            0.6 * glm::length(tour->front().eye - tour->front().target));
}

TEST(Tour, OfAWorldWithoutItsRootIsAnError) {
  test::MemorySource source(world().files);
  source.remove(node_file(world().index.nodes[0], ".glb"));
  EXPECT_FALSE(tour_of(source, world().index).ok());
}

TEST(LooksAtWorld, KnowsWhatIsAwayBehindAndFar) {
  const Bounds b = world_bounds(world().index);
  const glm::dvec3 centre = (b.min + b.max) / 2.0;
  const double size = glm::length(b.max - b.min);
  const auto looks = [&](const glm::dvec3& eye, const glm::dvec3& target) {
    return looks_at_world(world().index, {0, eye, target}, 16.0 / 9).value();
  };
  EXPECT_TRUE(looks(centre + glm::dvec3(0, -size, 0), centre));
  EXPECT_FALSE(looks(centre + glm::dvec3(0, -size, 0), centre + glm::dvec3(0, -9 * size, 0)));
  EXPECT_FALSE(looks(centre + glm::dvec3(0, -200 * size, 0), centre));
  const glm::dvec3 inside(centre.x, centre.y, b.min.z + 1);
  EXPECT_TRUE(looks(inside, inside + glm::dvec3(1, 0, 0)));
  EXPECT_FALSE(looks(inside + glm::dvec3(0, 0, size), inside + glm::dvec3(0, 0, 2 * size)));
}

// Where a level's triangles come from, and that the streamer takes such a world.
TEST(LevelSource, HoldsTheWorldDownToADepth) {
  test::MemorySource whole(world().files);
  for (std::uint32_t depth = 0; depth < kShape.levels; ++depth) {
    const WorldIndex cut = cut_at_depth(world().index, depth);
    std::size_t nodes = 0;
    for (std::uint32_t d = 0, row = 1; d <= depth; ++d, row *= 4) nodes += row;
    ASSERT_EQ(cut.nodes.size(), nodes);
    LevelSource source(whole, cut);
    const auto read = read_world_index(source);
    ASSERT_TRUE(read.ok()) << read.error().describe();
    HeapPageSink sink;
    const auto streamer = Streamer::open(
        source, {.cap_bytes = 64 << 20, .tolerance = 1e-9, .include_detail = true, .settle = true}, sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    const View view{{test::kTinyOrigin_m, test::kTinyOrigin_m, 10}};
    for (int i = 0; i < 4; ++i) ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), i).ok());
    ASSERT_EQ((*streamer)->rendered_cut().size(), std::size_t{1} << (2 * depth));
    for (const std::uint32_t node : (*streamer)->rendered_cut())
      EXPECT_EQ((*streamer)->index().nodes[node].depth, depth);
  }
}

}  // namespace
}  // namespace zc
