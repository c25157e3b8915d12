// SPDX-License-Identifier: Apache-2.0
// What `zonecast bench trace` asks of an engine: build over a scene, trace rays, say what both cost. Our own kernels
// and every peer stand behind this one interface, so that all see the same triangles and the same rays.
// Units: metres relative to the scene's local origin; milliseconds; bytes. Threads: one at a time.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc::bench {

struct BenchRay {
  float ox = 0, oy = 0, oz = 0;
  float dx = 0, dy = 0, dz = 0;  // unit
};
static_assert(sizeof(BenchRay) == 24);

struct BenchTriangle {
  std::array<float, 9> v = {};  // three corners
};
static_assert(sizeof(BenchTriangle) == 36);

inline constexpr std::uint32_t kMiss = 0xFFFFFFFF;

struct BenchHit {
  float t = std::numeric_limits<float>::infinity();  // along the ray's direction
  std::uint32_t triangle = kMiss;                    // index in BenchScene::triangles
};
static_assert(sizeof(BenchHit) == 8);

// A run of triangles that a world would keep in one page: differences of its vertices are multiples of 2^step_shift
// steps and below 2^16 of those, so that it fits 16-bit offsets.
struct BenchZone {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::uint32_t step_shift = 0;
};

struct BenchScene {
  std::string name;
  // Every coordinate is a multiple of step_m below 2^24 steps: exact in float. No triangle is without area.
  std::vector<BenchTriangle> triangles;
  std::vector<BenchZone> zones;             // in order, cover all triangles, none empty
  std::array<std::int64_t, 3> origin = {};  // the local origin: lattice steps in the CRS
  double step_m = 0x1p-8;
};

struct BuildFigures {
  double build_ms = 0;
  std::uint64_t bytes = 0;  // all that tracing reads, beside the rays
};

class TraceEngine {
 public:
  TraceEngine() = default;
  TraceEngine(const TraceEngine&) = delete;
  TraceEngine& operator=(const TraceEngine&) = delete;
  virtual ~TraceEngine() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  // Once, before the first trace. The scene stays alive as long as the engine.
  virtual Status build(const BenchScene& scene) = 0;
  [[nodiscard]] virtual BuildFigures figures() const = 0;
  // Closest hit of each ray with t in [0, inf), both sides of a triangle; or, of an engine made for any hit, whether
  // there is one: kMiss, or a triangle's index. Returns the milliseconds that tracing took, without moving rays and
  // hits between memories.
  virtual Result<double> trace(std::span<const BenchRay> rays, std::span<BenchHit> hits) = 0;
};

}  // namespace zc::bench
