// SPDX-License-Identifier: Apache-2.0
// A replay: a world, a path or several, a cap, and what came of it. The composition root's own composition.
// Threads: one caller. Fails on bad input, a cap that is too small, a device that refuses.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "replay/session/camera_path.h"
#include "replay/session/units.h"
#include "streamer/streamer.h"

namespace zc {

// Where the kernels that trace come from.
enum class KernelChoice {
  kFixed,    // renderer.trace
  kAuto,     // what variant_cache holds; where that is nothing, as kMeasure
  kMeasure,  // measured on the first frame that queues rays enough, and cached
};

// Where the appearance-ahead comes from.
enum class Prediction {
  kPath,      // the recording knows
  kVelocity,  // what a live camera's last two frames tell
};

struct ReplayOptions {
  std::filesystem::path world;
  SourceOptions source;
  // One a camera; none: one that follows tour_of() the world. Frames are the first one's samples; the others are where
  // they are at those times.
  std::vector<CameraPath> paths;
  std::filesystem::path out;  // empty: no files; pictures that an earlier run left there go
  StreamerOptions streamer;
  std::uint64_t host_budget_bytes = 256ULL << 20U;  // of the host's full-detail zones, outside the cap
  double look_ahead_s = 2;
  Prediction prediction = Prediction::kPath;
  bool trace = false;  // write trace.json
  FrameRange frames;
  bool render = true;
  bool leave_nothing_out = false;
  bool contact_sheet = false;
  std::string device;
  bool validation = false;
  HostOptions renderer;
  std::optional<SunAngles> sun;  // none: the bake's, where it had one
  KernelChoice kernel = KernelChoice::kFixed;
  std::filesystem::path variant_cache;  // a file; empty: nothing is read or kept
  std::vector<DebugView> debug_views;
  std::function<void(double fraction, std::string_view stage)> progress;
  std::function<void(const Error&)>
      on_failure;  // a page, a kernel, a cache that failed, a path that sees nothing; the replay goes on
};

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
  RayCounts rays;
  std::uint64_t rendered_frames = 0;
  std::array<double, kPassCount> pass_ms = {};  // medians
  double total_ms = 0;                          // median
  std::vector<std::string> left_out;
  std::string device, driver;
  std::string trace_variant;         // the kernels that the last frame was traced by; empty without pictures
  std::string trace_variant_origin;  // fixed, cached, measured; default: nothing was
  double measure_ms = 0;             // that the self-measurement took, if there was one
  std::uint64_t validation_messages = 0;
};

Result<ReplayReport> run_replay(const ReplayOptions& options);

}  // namespace zc
