// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/camera_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "replay/paths/spread_evenly.h"

namespace zc {
namespace {

// 10 m a second along x for two seconds, at so far along y.
CameraPath straight(double y) {
  CameraPath path;
  for (const double time_s : {0.0, 1.0, 2.0}) path.push_back({time_s, {10 * time_s, y, 0}, {1000, y, 0}});
  return path;
}

TEST(CameraRig, OtherCamerasAreWhereTheyAreAtTheTimesOfTheFirst) {
  CameraPath second = straight(5);
  second.erase(second.begin() + 1);  // 0 s and 2 s
  const std::array paths = {straight(0), second};
  const CameraRig rig(paths, 0, Prediction::kPath);
  const std::vector<CameraSample> cameras = rig.cameras(1);
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[0].eye, glm::dvec3(10, 0, 0));
  EXPECT_EQ(cameras[1].eye, glm::dvec3(10, 5, 0));
}

TEST(CameraRig, LooksAheadAlongThePathUntilItsEnd) {
  const std::array paths = {straight(0)};
  CameraRig rig(paths, 1.6, Prediction::kPath);
  const std::vector<View> views = rig.look_ahead(rig.cameras(1));
  ASSERT_EQ(views.size(), 9U);
  for (std::uint32_t i = 0; i < views.size(); ++i) {
    EXPECT_NEAR(views[i].eye.x, std::min(20.0, 10 + 2.0 * i), 1e-9) << i;
    EXPECT_EQ(views[i].steps_ahead, i);
  }
}

TEST(CameraRig, KnowsALiveCamerasVelocityFromItsSecondFrameOn) {
  const std::array paths = {straight(0), straight(7)};
  CameraRig rig(paths, 2, Prediction::kVelocity);
  for (const View& view : rig.look_ahead(rig.cameras(0))) EXPECT_EQ(view.eye.x, 0);
  double farthest = 0;
  for (const View& view : rig.look_ahead(rig.cameras(2))) {
    EXPECT_TRUE(view.eye.y == 0 || view.eye.y == 7);
    farthest = std::max(farthest, view.eye.x);
  }
  EXPECT_NEAR(farthest, 40, 1e-9);  // 20 m in 2 s since the frame before, and 2 s more
}

TEST(CameraRig, AStillViewStaysWhereItIs) {
  CameraPath shots = straight(0);
  for (CameraSample& sample : shots) sample.name = "shot";
  const std::array paths = {shots};
  CameraRig rig(paths, 2, Prediction::kPath);
  EXPECT_EQ(rig.look_ahead(rig.cameras(0)).size(), 1U);
}

TEST(FrameRange, CountsWhatLiesOnThePath) {
  const CameraPath path(10);
  EXPECT_EQ(FrameRange{}.within(path).count(), 10U);
  EXPECT_EQ((FrameRange{2, 9, 3}.within(path).count()), 3U);  // 2, 5, 8
  EXPECT_EQ((FrameRange{2, 9, 3}.at(2)), 8U);
  EXPECT_EQ((FrameRange{9, 50, 4}.within(path).count()), 1U);
  EXPECT_EQ((FrameRange{10, 50, 1}.within(path).count()), 0U);
}

TEST(FrameName, IsTheViewsOrSixDigits) {
  EXPECT_EQ(frame_name({}, 42), "000042");
  EXPECT_EQ(frame_name({}, 12345678), "12345678");
  CameraSample view;
  view.name = "plaza";
  EXPECT_EQ(frame_name(view, 42), "plaza");
}

TEST(SpreadEvenly, IncludesTheFirstAndTheLast) {
  EXPECT_EQ(spread_evenly(3, 12), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(spread_evenly(100, 4), (std::vector<std::size_t>{0, 33, 66, 99}));
  EXPECT_EQ(spread_evenly(100, 1), (std::vector<std::size_t>{0}));
  EXPECT_TRUE(spread_evenly(0, 4).empty());
}

}  // namespace
}  // namespace zc
