// SPDX-License-Identifier: Apache-2.0
// A queue of rays on the device, and the kernels that trace it against one set of zones: in packets where the device
// can, the rest as fallback rays one by one. Which kernels are the fastest is measured here too.
// Owns: queue, hits, counters, kernels. Borrows device and programs. Threads: as the device.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "runtime/device/program_cache.h"
#include "runtime/device/resources.h"
#include "runtime/tracing/trace_variant.h"

namespace zc {

// The constant_id of each specialisation constant that shaders here declare.
enum ConstantId : std::uint32_t {
  kConstantStackSize = 0,
  kConstantUseScreen = 1,
  kConstantPoolPath = 3,
  kConstantRaysPerLane = 4,
  kConstantCheckAccess = 5,
  kConstantStackShared = 6,
  kConstantTraceWidth = 7,
  kConstantAnyHit = 8,
  kConstantStepLimit = 9,
  kConstantThreadPerPixel = 10,
};

// The kernels that trace and say what they hit, where the pool has another layout than pages: `zonecast bench trace`
// measures others with everything else as it is. Empty: those for pages.
struct LayoutKernels {
  std::span<const std::uint32_t> packets, rays, resolve;
};

struct TraceQueueOptions {
  std::uint32_t max_rays = 0;
  TraceLimits limits;         // see trace_limits()
  TraceVariant variant;       // where it is not supported: nearest_fit()
  bool check_access = false;  // count reads outside the traced pages, and divert them: for tests
  LayoutKernels kernels = {};
};

// What tracing takes on this device: of pages of at most page_depth nodes on a path, below so deep a top level, in a
// pool that is bound as texels as a whole or not. step_limit: 0 for the device's.
TraceLimits trace_limits(const Device& device, std::uint32_t page_depth, std::uint32_t top_level_depth,
                         bool pool_as_texels, std::uint32_t step_limit = 0);

class TraceQueue {
 public:
  static constexpr std::uint32_t kRaysToChoose = 4096;  // fewer do not tell one kernel from another

  TraceQueue(Device& device, ProgramCache& programs) : device_(device), programs_(programs) {}
  TraceQueue(const TraceQueue&) = delete;
  TraceQueue& operator=(const TraceQueue&) = delete;
  ~TraceQueue();
  Status create(const TraceQueueOptions& options);

  // What the queue's kernels, and passes that fill the queue or read the hits, bind.
  void bind_to(BindingTable& table) const;
  // All other specialisation of programs that read pages as the kernels in use do.
  [[nodiscard]] Constants constants() const { return constants_of(options_.variant, false); }

  // Compiles what recording needs.
  Status prepare(bool any_hit);
  // Turns counts into indirect arguments, after which record_trace() and passes over the queue may follow.
  void record_sizes(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot) const;
  // The ray queue, in packets first.
  void record_trace(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot) const;

  [[nodiscard]] const Buffer& rays() const { return rays_; }
  [[nodiscard]] const Buffer& hits() const { return hits_; }
  [[nodiscard]] const Buffer& counters() const { return counters_; }
  [[nodiscard]] const TraceVariant& variant() const { return options_.variant; }
  [[nodiscard]] const TraceLimits& limits() const { return options_.limits; }
  // Of its buffers.
  [[nodiscard]] std::uint64_t bytes() const;
  Status set_variant(const TraceVariant& variant, bool any_hit);

  // Submits and waits: traces the first ray_count rays of the queue; returns milliseconds.
  Result<double> trace_now(std::uint32_t ray_count, const BindingTable& table, std::uint32_t slot);
  // Submits and waits: measures kernels on the rays that were queued last, ray_count of them and at least
  // kRaysToChoose, and goes on with the fastest. What has not begun after budget_ms is not measured: false. Queue, hits
  // and counters are of no use afterwards.
  Result<bool> choose_variant(std::uint32_t ray_count, const BindingTable& table, std::uint32_t slot,
                              double budget_ms = INFINITY);

 private:
  struct Kernels {
    Program* size = nullptr;
    Program* packets = nullptr;  // none: rays one by one
    Program* rays = nullptr;
  };
  [[nodiscard]] Constants constants_of(const TraceVariant& variant, bool any_hit) const;
  Result<Kernels> make_kernels(const TraceVariant& variant, bool any_hit) const;
  Status thin_out(std::uint32_t ray_count, std::uint32_t runs);

  Device& device_;
  ProgramCache& programs_;
  TraceQueueOptions options_;
  Kernels kernels_;
  Buffer rays_, hits_, fallback_rays_, counters_, counters_upload_, thinned_;
  BufferView ray_texels_;
  VkQueryPool queries_ = VK_NULL_HANDLE;
};

}  // namespace zc
