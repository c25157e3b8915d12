// SPDX-License-Identifier: Apache-2.0
// The cameras of a replay: one a path, all at the times of the first one's samples, which are the frames; and the views
// that paging takes from them, now and ahead.
// Borrows the paths. Units: CRS metres, seconds. Threads: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "replay/paths/camera_path.h"
#include "streamer/paging/selection.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// How the look-ahead knows where a camera will be.
enum class Prediction {
  kPath,      // from the recording
  kVelocity,  // from the last two frames, as for a live camera
};

// Where cameras are.
std::vector<View> views_of(const std::vector<CameraSample>& cameras);

class CameraRig {
 public:
  // paths: at least one.
  CameraRig(std::span<const CameraPath> paths, double look_ahead_s, Prediction prediction);

  [[nodiscard]] std::size_t size() const { return paths_.size(); }
  [[nodiscard]] const CameraPath& lead() const { return paths_.front(); }
  // Every camera in a frame, in the order of the paths.
  [[nodiscard]] std::vector<CameraSample> cameras(std::uint64_t frame) const;
  // Whether a camera looks at the world in one of the frames from begin to end, whatever the step between them. Fails
  // as make_camera() where one of them lies too far away.
  [[nodiscard]] Result<bool> sees_world(const IndexView& index, const FrameRange& frames, double aspect) const;
  // Where the cameras of a frame are, and where they will be; a still view stays where it is. Frame by frame, in
  // ascending order.
  std::vector<View> look_ahead(const std::vector<CameraSample>& cameras);

 private:
  std::span<const CameraPath> paths_;
  double look_ahead_s_;
  Prediction prediction_;
  std::vector<CameraSample> previous_;  // of the frame before
};

}  // namespace zc
