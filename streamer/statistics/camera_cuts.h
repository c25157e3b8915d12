// SPDX-License-Identifier: Apache-2.0
// How long it takes after a camera jumped until everything it asks for is there. Threads: one · units: seconds of the
// path's clock, CRS metres.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "streamer/paging/selection.h"
#include "streamer/statistics/latency_samples.h"
#include "streamer/statistics/statistics.h"

namespace zc {

inline constexpr double kCameraCut_m = 100;
inline constexpr double kCameraCut_m_per_s = 1000;

class CameraCuts {
 public:
  // At the start of a frame; the views that are now, one a camera, always in the same order.
  void begin_frame(std::span<const View> views, double time_s);
  // At its end.
  void end_frame(bool everything_there);

  [[nodiscard]] CameraCutStatistics statistics() const;

 private:
  std::vector<glm::dvec3> eyes_;  // one a camera
  double time_s_ = 0;
  std::optional<double> jumped_s_;  // what was asked for then is not all there yet
  std::uint64_t count_ = 0;
  std::uint64_t unfinished_ = 0;
  LatencySamples to_target_;
};

}  // namespace zc
