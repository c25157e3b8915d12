// SPDX-License-Identifier: Apache-2.0
// Scenes and rays for `zonecast bench`: from a baked world, from raw float files, from a camera.
// Units: metres; lattice steps where a name says so. Untrusted input: sizes are checked before memory is taken, values
// that are no numbers or beyond 1.8e18 are dropped and counted. Thread-safe: no state.
// Fails when a file does not follow its format, when nothing is left to trace, or when a coordinate lies 2^24 steps or
// more from the scene's local origin, where floats no longer hold it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/bench/engines/trace_engine.h"
#include "replay/bench/oracle.h"
#include "replay/paths/camera_path.h"
#include "streamer/source/source.h"

namespace zc::bench {

using CrsPoint = std::array<std::int64_t, 3>;  // lattice steps in the CRS

// Gathers zones of lattice triangles around a local origin.
class SceneAssembly {
 public:
  SceneAssembly(std::string name, const CrsPoint& origin, double step_m);
  void begin_zone(std::uint32_t step_shift);
  Status add(const std::array<CrsPoint, 3>& corners);
  Result<BenchScene> finish() &&;

 private:
  BenchScene scene_;
};

// The lattice point next to a position in the CRS. Fails beyond 10^12 m.
Result<CrsPoint> lattice_point(const glm::dvec3& position_m, double step_m);

// All full-detail zones of a baked world, moved by `offset_steps`. Local origin: the lattice point next to `eye_m`, or
// the world's anchor without one.
struct WorldSceneOptions {
  const CameraSample* camera = nullptr;  // in the CRS as moved
  CrsPoint offset_steps = {};
  SourceOptions source;
};
Result<BenchScene> load_world_scene(const std::filesystem::path& world, const WorldSceneOptions& options);

// Raw little-endian floats, `width` a record.
struct RawRecords {
  std::vector<float> values;
  std::uint64_t dropped = 0;  // records with a value that is no number, or beyond 1.8e18
};
Result<RawRecords> read_raw_records(const std::filesystem::path& file, std::size_t width);

struct RaySet {
  std::vector<BenchRay> rays;
  std::uint64_t dropped = 0;
};
// `ox oy oz dx dy dz` a ray, in the frame whose point `origin_m` is the scene's local origin. Directions are
// normalised; a direction of zero is an error.
Result<RaySet> read_rays(const std::filesystem::path& file, const glm::dvec3& origin_m);

enum class PixelOrder { kRows, kTiles };  // kTiles: 8×8 pixels after one another, as the renderer dispatches them

struct MirrorView {
  std::uint32_t width = 1280;
  std::uint32_t height = 720;
  PixelOrder order = PixelOrder::kTiles;
  unsigned threads = 1;
};
// A mirror ray from every pixel of the camera that sees a surface: reflected at the triangle's plane, starting four
// lattice steps off it.
Result<std::vector<BenchRay>> make_mirror_rays(const Oracle& oracle, const BenchScene& scene,
                                               const CameraSample& camera, const MirrorView& view);

}  // namespace zc::bench
