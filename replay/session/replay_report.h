// SPDX-License-Identifier: Apache-2.0
// What came of a replay. Units in names; times of passes are medians. Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "streamer/source/source.h"
#include "streamer/statistics/statistics.h"

namespace zc {

struct RayCounts {
  std::uint64_t total = 0, screen = 0, proxy = 0, proxy_coarse = 0, sky = 0, lost = 0;
};

struct ReplayReport {
  StreamerStatistics streaming;
  SourceStatistics source;
  std::optional<OptimalPaging> optimal;
  std::uint64_t baseline_rss_bytes = 0;
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t host_bytes = 0;
  FailingNodes host_failing;  // of the full detail that the host draws
  RayCounts rays;
  std::uint64_t rendered_frames = 0;
  std::array<double, kPassCount> pass_ms = {};
  double total_ms = 0;
  std::vector<std::string> left_out;
  std::string device, driver;
  std::string trace_variant;         // the kernels that the last frame was traced by; empty without pictures
  std::string trace_variant_origin;  // fixed, cached, measured; default: nothing was
  double measure_ms = 0;             // that the self-measurement took, if there was one
  std::uint64_t validation_messages = 0;
};

}  // namespace zc
