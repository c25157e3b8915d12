// SPDX-License-Identifier: Apache-2.0
// frames.csv: one row a frame, written as it happens under a temporary name and renamed when the replay is complete.
// Threads: one caller.
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "base/result.h"
#include "replay/files/text_file.h"
#include "replay/host/stand_in_host.h"
#include "streamer/statistics/statistics.h"

namespace zc {

class FrameLog {
 public:
  static Result<FrameLog> create(const std::filesystem::path& file, bool with_rays);
  // drawn: of all cameras together.
  Status add(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn);
  Status close() { return text_.close(); }

 private:
  explicit FrameLog(TextFile text) : text_(std::move(text)) {}
  TextFile text_;  // without close(): nothing is left behind
};

}  // namespace zc
