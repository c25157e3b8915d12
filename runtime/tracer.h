// SPDX-License-Identifier: Apache-2.0
// Rays in, hits out, against one set of zones: for tests and benchmarks. Submits and waits.
// Owns: a ray queue. Borrows: device and zones. Threads: as the device. Units: metres from the camera's lattice point.
#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "runtime/device/program_cache.h"
#include "runtime/device/resources.h"
#include "runtime/host_frame.h"
#include "runtime/scene/zone_set.h"
#include "runtime/tracing/trace_queue.h"
#include "shaders/shared/frame.h"
#include "shaders/shared/page.h"

namespace zc {

struct TracerOptions {
  std::uint32_t max_rays = 0;                     // at once
  std::uint32_t page_depth = gpu::kPageMaxDepth;  // deepest page that will be traced
  TraceVariant trace;                             // where it is not supported: nearest_fit()
  std::uint32_t step_limit = 0;                   // see ReflectionsOptions
  bool check_access = false;                      // count reads outside the traced pages, and divert them
  LayoutKernels kernels = {};
};

struct TracedHit {
  float t = 0;                  // metres
  std::uint32_t page_word = 0;  // the page's first word in the pool, or gpu::kHitNone / kHitLost
  std::uint32_t triangle = 0;   // position in that page
};

class Tracer {
 public:
  static Result<std::unique_ptr<Tracer>> create(Device& device, const ZoneSet& zones, const TracerOptions& options);
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  // Closest hits of 1 to max_rays rays up to the camera's ray_length_m; any_hit: only whether something is hit, and it
  // is open what and how far.
  Result<std::vector<TracedHit>> trace(const FrameCamera& camera, std::span<const gpu::RayTask> rays,
                                       bool any_hit = false, double* milliseconds = nullptr);
  // What the last trace() counted.
  [[nodiscard]] const gpu::Counters& counters() const { return counters_; }
  [[nodiscard]] const TraceVariant& trace_variant() const { return queue_.variant(); }
  // On the rays of the last trace(): see TraceQueue::choose_variant.
  Result<bool> choose_trace_variant(std::uint32_t ray_count, double budget_ms = INFINITY);

 private:
  Tracer(Device& device, const ZoneSet& zones)
      : device_(device), zones_(zones), programs_(device), queue_(device, programs_) {}
  Status create(const TracerOptions& options);

  Device& device_;
  const ZoneSet& zones_;
  LayoutKernels kernels_;
  ProgramCache programs_;
  TraceQueue queue_;
  Buffer frame_, transfer_;
  BindingTable table_;
  gpu::Counters counters_ = {};
};

}  // namespace zc
