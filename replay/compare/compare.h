// SPDX-License-Identifier: Apache-2.0
// Proxies seen from the eye, level by level, against the full detail: pictures, maps of FLIP and their means.
// Threads: one caller. Fails on bad input, a budget that is too small, a device or a disk that refuses.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "replay/paths/camera_path.h"
#include "streamer/source/source.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

struct CompareOptions {
  std::filesystem::path world;
  SourceOptions source;
  CameraPath path;                   // empty: tour_of() the world
  std::optional<FrameRange> frames;  // none: eight, spread evenly over the path
  std::filesystem::path out;
  HostOptions renderer;
  std::optional<SunAngles> sun;
  std::vector<double> tolerances = {0.002};  // a level each, as a replay would page
  unsigned threads = 2;
  std::string device;
  std::uint64_t budget_bytes = 256ULL << 20U;  // of each level's zones
  std::function<void(double fraction, std::string_view stage)> progress;
};

struct ComparedLevel {
  std::string name;
  std::optional<double> tolerance;     // of a replay's
  std::optional<std::uint32_t> depth;  // of a stored one
  double error_max_m = 0;              // of a stored one: how far its surface is from the source's at most
  std::vector<double> flip;            // mean of each frame
  std::uint64_t triangles = 0;         // of the zones drawn, all frames together
  double mean_flip = 0;
  bool incomplete = false;  // the budget had no room for all of it: coarser where it is far away
};

struct CompareReport {
  std::vector<std::string> frames;  // names
  std::size_t blind_frames = 0;     // that do not look at the world
  bool limited_by_device = false;   // where zones were left out: by what the device binds, not by the budget
  bool source_complete = true;      // the budget had room for all of the full detail
  std::vector<ComparedLevel> levels;
  std::string device;
};

// Levels: "finest", then what is stored at every coarser depth, "level_D", of which at most eight that are spread
// evenly; then "tolerance_T". Writes `out`/<level>/<frame>.png, `out`/<level>_flip/<frame>.png, the same of "source",
// `out`/contact_sheet.png (at most twelve frames, spread evenly) and `out`/compare.json; pictures that an earlier run
// left there go. Fails before that where no frame looks at the world.
Result<CompareReport> run_compare(const CompareOptions& options);

}  // namespace zc
