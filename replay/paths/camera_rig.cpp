// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/camera_rig.h"

#include "base/check.h"
#include "replay/paths/frame_camera.h"
#include "replay/paths/world_tour.h"
#include "streamer/paging/look_ahead.h"

namespace zc {
namespace {

constexpr std::uint32_t kLookAheadViews = 8;

}  // namespace

std::vector<View> views_of(const std::vector<CameraSample>& cameras) {
  std::vector<View> views;
  views.reserve(cameras.size());
  for (const CameraSample& camera : cameras) views.push_back({camera.eye});
  return views;
}

CameraRig::CameraRig(std::span<const CameraPath> paths, double look_ahead_s, Prediction prediction)
    : paths_(paths), look_ahead_s_(look_ahead_s), prediction_(prediction) {
  ZC_CHECK(!paths_.empty());
}

std::vector<CameraSample> CameraRig::cameras(std::uint64_t frame) const {
  std::vector<CameraSample> cameras = {lead()[frame]};
  for (std::size_t c = 1; c < paths_.size(); ++c) cameras.push_back(camera_at(paths_[c], cameras.front().time_s));
  return cameras;
}

Result<bool> CameraRig::sees_world(const IndexView& index, const FrameRange& frames, double aspect) const {
  bool seen = false;
  for (std::uint64_t frame = frames.begin; frame < frames.end; ++frame) {
    for (const CameraSample& sample : cameras(frame)) {
      if (const auto camera = make_camera(index, sample); !camera) return camera.error();
      if (!seen) {
        ZC_ASSIGN(seen, looks_at_world(index, sample, aspect));
      }
    }
  }
  return seen;
}

std::vector<View> CameraRig::look_ahead(const std::vector<CameraSample>& cameras) {
  const double time_s = cameras.front().time_s;
  std::vector<View> views;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const glm::dvec3 eye = cameras[c].eye;
    if (!cameras[c].name.empty()) {
      views.push_back({eye});
    } else if (prediction_ == Prediction::kVelocity) {
      const double passed_s = previous_.empty() ? 0 : time_s - previous_.front().time_s;
      const glm::dvec3 velocity = passed_s > 0 ? (eye - previous_[c].eye) / passed_s : glm::dvec3();
      extrapolate_views(eye, velocity, look_ahead_s_, kLookAheadViews, views);
    } else {
      views.push_back({eye});
      for (std::uint32_t i = 1; i <= kLookAheadViews && look_ahead_s_ > 0; ++i)
        views.push_back({eye_at(paths_[c], time_s + look_ahead_s_ * i / kLookAheadViews), i});
    }
  }
  previous_ = cameras;
  return views;
}

}  // namespace zc
