// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/camera_cuts.h"

#include <glm/geometric.hpp>

namespace zc {

void CameraCuts::begin_frame(std::span<const View> views, double time_s) {
  const double passed_s = time_s - time_s_;
  time_s_ = time_s;
  bool jumped = false;
  std::size_t camera = 0;
  for (const View& view : views) {
    if (view.steps_ahead != 0) continue;
    if (camera < eyes_.size()) {
      const double moved_m = glm::distance(eyes_[camera], view.eye);
      jumped = jumped || (moved_m >= kCameraCut_m && moved_m > kCameraCut_m_per_s * passed_s);
      eyes_[camera] = view.eye;
    } else {
      eyes_.push_back(view.eye);
    }
    ++camera;
  }
  if (!jumped) return;
  ++count_;
  if (jumped_s_) ++unfinished_;
  jumped_s_ = time_s;
}

void CameraCuts::end_frame(bool everything_there) {
  if (!jumped_s_ || !everything_there) return;
  to_target_.add(1e3 * (time_s_ - *jumped_s_));
  jumped_s_.reset();
}

CameraCutStatistics CameraCuts::statistics() const {
  return {count_, unfinished_ + (jumped_s_ ? 1 : 0), to_target_.summary()};
}

}  // namespace zc
