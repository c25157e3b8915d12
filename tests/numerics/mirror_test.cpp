// SPDX-License-Identifier: GPL-3.0-or-later
// What a flat mirror shows is what a mirrored camera sees: an exact truth for the whole chain of passes.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "tests/numerics/rendered_world.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

constexpr std::uint32_t kWidth = 320;
constexpr std::uint32_t kHeight = 240;

// Boxes of different colours that stand on a floor of perfect mirror at z = 0, or on nothing.
Scene boxes(bool floor) {
  test::SceneMaker maker;
  maker.scene.materials.push_back({"mirror", {1, 1, 1}, 0.01F, 1});
  maker.scene.materials.push_back({"red", {0.7F, 0.05F, 0.05F}, 1, 0});
  maker.scene.materials.push_back({"blue", {0.05F, 0.1F, 0.7F}, 1, 0});
  if (floor) {
    maker.quad({-60, -60, 0}, {60, -60, 0}, {60, 60, 0}, {-60, 60, 0}, 4);
    maker.object(ObjectKind::kGround);
  }
  for (int i = 0; i < 5; ++i) {
    const auto first = maker.scene.triangles.size();
    maker.box({-22 + 9 * i, 12 + 3 * (i % 3), 0}, {-17 + 9 * i, 17 + 3 * (i % 3), 4 + 2.5 * i});
    for (auto t = first; t < maker.scene.triangles.size(); ++t) {
      if (maker.scene.triangle_material[t] == 0)
        maker.scene.triangle_material[t] = static_cast<std::uint16_t>(i % 2 == 0 ? 5 : 6);
    }
    maker.object(ObjectKind::kObject);
  }
  return std::move(maker.scene);
}

struct Comparison {
  std::size_t mirror_pixels = 0;
  std::size_t wrong = 0;       // further than 8 of 255 in some channel
  double mean_difference = 0;  // of 255
  FrameResult frame;
};

class Mirror : public testing::TestWithParam<ReflectionMode> {};

Comparison compare(ReflectionMode mode, const glm::dvec3& eye, glm::vec3 forward) {
  Comparison result;
  HostOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.reflections = mode;
  test::RenderedWorld with_floor;
  test::RenderedWorld without;
  BakeOptions bake;
  bake.light = false;  // a floor would shine back
  for (const Status& opened :
       {with_floor.open(boxes(true), bake, options), without.open(boxes(false), bake, options)}) {
    EXPECT_TRUE(opened.ok()) << opened.error().describe();
    if (!opened.ok()) return result;
  }
  forward = glm::normalize(forward);
  const glm::vec3 right = glm::normalize(glm::cross(forward, glm::vec3(0, 0, 1)));
  const glm::vec3 up = glm::cross(right, forward);
  const glm::vec3 flip(1, 1, -1);

  const auto frame = with_floor.render(with_floor.camera(eye, right, up, forward));
  EXPECT_TRUE(frame.ok());
  const auto seen = with_floor.renderer().pixels();
  const std::vector<std::byte> picture(seen.begin(), seen.end());
  EXPECT_TRUE(with_floor.renderer().draw_debug(DebugView::kNormals, {}).ok());
  const auto normals = with_floor.renderer().pixels();
  EXPECT_TRUE(without.render(without.camera(eye * glm::dvec3(flip), right * flip, up * flip, forward * flip)).ok());
  const auto truth = without.renderer().pixels();
  EXPECT_EQ(with_floor.device().validation_messages() + without.device().validation_messages(), 0U);

  result.frame = *frame;
  for (std::size_t i = 0; i < picture.size(); i += 4) {
    // The floor is what faces up and is not a roof: roofs are above the horizon of an eye this low.
    const auto channel = [](std::span<const std::byte> p, std::size_t at) { return static_cast<int>(p[at]); };
    const bool floor = channel(normals, i + 2) > 250 && channel(normals, i) > 120 && channel(normals, i) < 135 &&
                       i / 4 / kWidth > kHeight / 2;
    if (!floor) continue;
    ++result.mirror_pixels;
    int worst = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const int difference = std::abs(channel(picture, i + c) - channel(truth, i + c));
      worst = std::max(worst, difference);
      result.mean_difference += difference / 3.0;
    }
    if (worst > 8) ++result.wrong;
  }
  result.mean_difference /= static_cast<double>(std::max<std::size_t>(1, result.mirror_pixels));
  return result;
}

TEST_P(Mirror, ShowsWhatAMirroredCameraSees) {
  const Comparison c = compare(GetParam(), {0.3, -9.7, 1.6}, {0.03F, 1, -0.12F});
  EXPECT_GT(c.mirror_pixels, kWidth * kHeight / 4U);
  // Only pixels on the outlines of the boxes may differ.
  EXPECT_LT(static_cast<double>(c.wrong), 0.01 * static_cast<double>(c.mirror_pixels));
  EXPECT_LT(c.mean_difference, 1.0);
  EXPECT_EQ(c.frame.counters.rays_lost, 0U);
  const gpu::Counters& n = c.frame.counters;
  EXPECT_EQ(n.pixel_count, n.rays_screen + n.rays_proxy + n.rays_proxy_coarse + n.rays_sky + n.rays_lost);
  if (GetParam() == ReflectionMode::kScreenAndProxy) {
    // A camera this low shows the front of every box: the screen holds most of what the floor mirrors.
    EXPECT_GT(n.rays_screen, 10 * n.rays_proxy);
  } else {
    EXPECT_EQ(n.rays_screen, 0U);
    EXPECT_GT(n.rays_proxy, 0U);
  }
  std::printf("%zu mirror pixels, %zu wrong, mean difference %.3f\n", c.mirror_pixels, c.wrong, c.mean_difference);
}

TEST_P(Mirror, ShowsWhatIsOffTheScreen) {
  // Looking down past the boxes: most of what the floor mirrors is above the picture.
  const Comparison c = compare(GetParam(), {0.3, 2.7, 9}, {0.03F, 1, -1.1F});
  EXPECT_LT(static_cast<double>(c.wrong), 0.01 * static_cast<double>(c.mirror_pixels));
  EXPECT_EQ(c.frame.counters.rays_lost, 0U);
  EXPECT_GT(c.frame.counters.rays_proxy, 0U);
  std::printf("%zu mirror pixels, %zu wrong, mean difference %.3f\n", c.mirror_pixels, c.wrong, c.mean_difference);
}

// A row of mirror façades and a row of red ones across the street, seen through proxies far coarser than the street is
// wide: the red ones must still be met, for they wind against the mirror.
TEST(CoarseProxies, AreNotTakenForTheSurfaceThatARayLeaves) {
  test::SceneMaker maker;
  maker.scene.materials.push_back({"mirror", {1, 1, 1}, 0.01F, 1});
  maker.scene.materials.push_back({"red", {0.7F, 0.05F, 0.05F}, 1, 0});
  const auto wall = [&](double y, double facing, std::uint16_t material) {
    if (facing > 0) {
      maker.quad({30, y, 0}, {-30, y, 0}, {-30, y, 12}, {30, y, 12}, material);
    } else {
      maker.quad({-30, y, 0}, {30, y, 0}, {30, y, 12}, {-30, y, 12}, material);
    }
    maker.object(ObjectKind::kObject);
  };
  wall(10, -1, 4);   // mirror, towards -y
  wall(-10, +1, 5);  // red, towards +y
  HostOptions options;
  options.width = 160;
  options.height = 120;
  options.reflections = ReflectionMode::kProxy;
  test::RenderedWorld world;
  const Status opened = world.open(std::move(maker.scene), {}, options, /*claimed_error_m=*/100.0F);
  ASSERT_TRUE(opened.ok()) << opened.error().describe();
  const auto frame = world.render(world.camera({0.1, -5.2, 6.3}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->counters.pixel_count, frame->counters.rays_proxy + frame->counters.rays_sky);
  EXPECT_GT(frame->counters.rays_proxy, frame->counters.pixel_count / 4);
  // And a proxy that lies behind the mirror's own surface is not met from it: no mirror shows itself.
  const auto middle = world.renderer().pixels().subspan((60 * 160 + 80) * 4, 3);
  EXPECT_GT(static_cast<int>(middle[0]), 2 * static_cast<int>(middle[1]));
}

INSTANTIATE_TEST_SUITE_P(Modes, Mirror,
                         testing::Values(ReflectionMode::kScreenAndProxy, ReflectionMode::kProxy,
                                         ReflectionMode::kFull),
                         [](const auto& mode) {
                           return std::string(mode.param == ReflectionMode::kScreenAndProxy ? "ScreenAndProxy"
                                              : mode.param == ReflectionMode::kProxy        ? "Proxy"
                                                                                            : "Full");
                         });

}  // namespace
}  // namespace zc
