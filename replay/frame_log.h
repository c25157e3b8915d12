// SPDX-License-Identifier: Apache-2.0
// frames.csv: one row a frame, written as it happens under a temporary name and renamed when the replay is complete.
// Threads: one caller.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "base/result.h"
#include "runtime/renderer.h"
#include "streamer/statistics.h"

namespace zc {

class FrameLog {
 public:
  static Result<FrameLog> create(const std::filesystem::path& file, bool with_rays);
  FrameLog(FrameLog&&) = default;
  FrameLog& operator=(FrameLog&&) = default;
  ~FrameLog();  // without close(): nothing is left behind

  Status add(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn);
  Status close();

 private:
  FrameLog() = default;
  std::filesystem::path file_, temporary_;
  std::ofstream stream_;
};

}  // namespace zc
