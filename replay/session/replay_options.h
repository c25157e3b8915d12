// SPDX-License-Identifier: Apache-2.0
// What a replay is asked for. Plain values.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/host/stand_in_host.h"
#include "replay/paths/camera_path.h"
#include "replay/paths/camera_rig.h"
#include "streamer/paging/streamer_options.h"
#include "streamer/source/source.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

// Where the kernels that trace come from.
enum class KernelChoice {
  kFixed,    // renderer.trace
  kAuto,     // what variant_cache contains; where that is nothing, as kMeasure
  kMeasure,  // measured on the first frame that queues enough rays, and cached
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
  std::function<void(std::uint64_t done, std::uint64_t frames)> progress;
  // A page, a kernel or a cache that failed, a path that sees nothing; the replay goes on.
  std::function<void(const Error&)> on_failure;

  void warn(const Error& error) const {
    if (on_failure) on_failure(error);
  }
  [[nodiscard]] double aspect() const { return static_cast<double>(renderer.width) / renderer.height; }
};

}  // namespace zc
