// SPDX-License-Identifier: Apache-2.0
// What a streamer is opened with. Units: bytes, seconds.
#pragma once

#include <cstdint>
#include <functional>

#include "base/result.h"

namespace zc {

enum class ClockKind { kVirtual, kWall };

struct StreamerOptions {
  std::uint64_t cap_bytes = 0;
  unsigned threads = 2;  // workers, at least 1
  ClockKind clock = ClockKind::kVirtual;
  double source_latency_s = 0;                        // virtual clock only
  double source_bandwidth_bytes_per_s = 0;            // virtual clock only; 0 is unlimited
  double tolerance = 0.002;                           // a node is refined when error_m / distance_m exceeds it
  bool include_detail = false;                        // also page full-detail nodes (the host's G-buffer, references)
  bool settle = false;                                // advance() waits for every selected load (offline capture)
  unsigned max_in_flight = 16;                        // requests outstanding, independent of threads
  std::uint64_t upload_bytes_per_frame = 0;           // of pages, at least one page a frame; 0 is unlimited
  std::function<void(const Error&)> on_failure = {};  // once per node, on the calling thread
};

}  // namespace zc
