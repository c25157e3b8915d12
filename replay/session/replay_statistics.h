// SPDX-License-Identifier: Apache-2.0
// What is counted while a replay runs: its pictures and the process's memory.
// Threads: one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "replay/session/replay_report.h"

namespace zc {

class ReplayStatistics {
 public:
  // Memory that the process takes from now on is the replay's.
  void begin();
  // Of one camera.
  void add_picture(const FrameResult& picture);
  void end_frame();
  // What was counted; the rest of the report is empty.
  [[nodiscard]] ReplayReport report();

 private:
  ReplayReport counted_;
  std::array<std::vector<double>, kPassCount> pass_ms_;
  std::vector<double> total_ms_;
};

// Several cameras' pictures as one frame's.
FrameResult sum_of(const std::vector<FrameResult>& pictures);

// Adds to left_out which of a scene's pages the device cannot bind, if there are any. scene: how the line begins.
void report_pool_limit(const std::string& scene, const StreamerStatistics& paging, ReplayReport& report);

}  // namespace zc
