// SPDX-License-Identifier: Apache-2.0
#include "replay/scene/paged_scene.h"

#include <gtest/gtest.h>

#include <span>

#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

const test::TinyWorld& world() {
  static const test::TinyWorld kWorld = test::make_tiny_world({});
  return kWorld;
}

TEST(PagedScene, PagesOntoTheHeapWithoutADevice) {
  test::MemorySource source(world().files);
  PagedScene scene;
  const Status opened = scene.open(source, "city", {.cap_bytes = 64 << 20});
  ASSERT_TRUE(opened.ok()) << opened.error().describe();
  EXPECT_EQ(scene.index().nodes.size(), world().index.nodes.size());
  const View view{{test::kTinyOrigin_m, test::kTinyOrigin_m, 10}};
  ASSERT_TRUE(scene.streamer().advance(std::span(&view, 1), 0).ok());
  EXPECT_FALSE(scene.streamer().rendered_cut().empty());
}

TEST(PagedScene, ItsErrorsNameTheWorldAndTheFileInIt) {
  test::MemorySource source(world().files);
  const std::string file = node_file(world().index.nodes[0], ".glb");
  source.remove(file);
  PagedScene scene;
  const Status opened = scene.open(source, "some/city", {.cap_bytes = 64 << 20});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().path, "some/city/" + file);
}

TEST(PagedScene, ACapThatIsTooSmallNamesTheWorld) {
  test::MemorySource source(world().files);
  PagedScene scene;
  const Status opened = scene.open(source, "some/city", {.cap_bytes = 1024});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kBudget);
  EXPECT_EQ(opened.error().path, "some/city");
}

}  // namespace
}  // namespace zc
