// SPDX-License-Identifier: Apache-2.0
// Proxies seen from the eye, level by level, against the full detail: pictures, maps of FLIP and their means.
// One caller.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "replay/camera_path.h"
#include "replay/units.h"
#include "runtime/renderer.h"
#include "streamer/source.h"

namespace zc {

struct CompareOptions {
  std::filesystem::path world;
  SourceOptions source;
  CameraPath path;
  FrameRange frames;
  std::filesystem::path out;
  RendererOptions renderer;
  std::optional<SunAngles> sun;
  unsigned threads = 2;
  std::string device;
  std::uint64_t budget_bytes = 256ULL << 20U;  // of each level's zones
  std::function<void(double fraction, std::string_view stage)> progress;
};

struct ComparedLevel {
  std::string name;
  double tolerance = 0;
  std::vector<double> flip;     // mean of each frame
  std::uint64_t triangles = 0;  // of the zones drawn, all frames together
  double mean_flip = 0;
};

struct CompareReport {
  std::vector<std::string> frames;  // names
  std::vector<ComparedLevel> levels;
  std::string device;
};

// Writes `out`/<level>/<frame>.png, `out`/<level>_flip/<frame>.png, `out`/contact_sheet.png (a row a frame: the source,
// every level, and below it the maps) and `out`/compare.json.
Result<CompareReport> run_compare(const CompareOptions& options);

}  // namespace zc
