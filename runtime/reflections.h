// SPDX-License-Identifier: Apache-2.0
// Reflections of a paged world for a host's frame: records commands that mirror the host's own picture where the screen
// shows what a ray hits, and the resident proxies elsewhere (Fredriksson & Scott 2016, "the thesis").
// It never submits, waits or reads back while recording: queue, submission and frames in flight are the host's.
//
// Owns: scratch buffers, pipelines. Borrows: the device and the zones, which outlive it. Threads: one at a time.
// Fails when the device lacks a limit, which it names, or when the driver refuses.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/device/program_cache.h"
#include "runtime/device/resources.h"
#include "runtime/host_frame.h"
#include "runtime/passes/pass.h"
#include "runtime/scene/zone_set.h"
#include "runtime/tracing/trace_queue.h"
#include "shaders/shared/frame.h"
#include "shaders/shared/page.h"
#include "shaders/shared/scene.h"

namespace zc {

// A pass's shader, compiled with a host's own files in the place of those in shaders/adapter/.
struct AdaptedShader {
  std::string_view pass;  // classify_pixels, march_screen or shade_hits
  std::span<const std::uint32_t> spirv;
};

struct ReflectionsOptions {
  std::uint32_t width = 1280;  // of the host's images, pixels
  std::uint32_t height = 720;
  bool screen = true;           // rays march through the depth buffer first; else all go to the proxies
  float roughness_cut = 0.35F;  // rougher surfaces do not mirror
  std::uint32_t screen_steps = 256;
  std::uint32_t page_depth = gpu::kPageMaxDepth;  // deepest page of the world: NodeRecord::bvh_depth
  TraceVariant trace;                             // where it is not supported: nearest_fit()
  std::uint32_t step_limit = 0;        // nodes that a ray may visit before it is lost; 0: step_limit() of the device
  std::uint32_t frames_in_flight = 2;  // at most kMaxFramesInFlight
  bool statistics = false;             // time the passes and read the counters back; see report()
  bool general = false;                // schedule every pass, whatever the scene needs: to measure what that costs
  bool check_access = false;           // count reads outside the traced pages, and divert them: for tests
  std::vector<AdaptedShader> adapted_shaders = {};  // borrowed code
  // Pixels are classified by a thread each; none: where the device is a GPU.
  std::optional<bool> thread_per_pixel = {};
};

struct PassTime {
  const char* key = "";
  double ms = 0;
};

// Of one frame that was executed.
struct FrameReport {
  gpu::Counters counters = {};
  std::vector<PassTime> passes;  // in the order of the frame; those that were recorded
};

struct LeftOutPass {
  std::string passes;  // keys, separated by commas
  std::string reason;
};

class Reflections {
 public:
  static Result<std::unique_ptr<Reflections>> create(Device& device, const ZoneSet& zones,
                                                     std::span<const gpu::MaterialEntry> materials,
                                                     const ReflectionsOptions& options);
  Reflections(const Reflections&) = delete;
  Reflections& operator=(const Reflections&) = delete;
  ~Reflections();

  // Other settings for the frames from now on; compiles only what is new, and what was there before not again. No
  // recorded frame may be in flight.
  Status reconfigure(const ReflectionsOptions& options);

  // Records a frame into a command buffer of the host's, outside a render pass. out: RGBA16F of the same size in layout
  // GENERAL, every texel of which is written: rgb the mirrored radiance, alpha 1 where a ray was followed and 0 where
  // the surface does not mirror. Reads of `out` need a barrier after compute shaders. The frame recorded
  // frames_in_flight frames ago must have been executed.
  Status record(VkCommandBuffer commands, const HostFrame& frame, VkImageView out);

  // Of the frame recorded last, with `statistics` on, once it was executed. Waits for nothing.
  [[nodiscard]] Result<FrameReport> report() const;
  // What its scene and settings leave out.
  [[nodiscard]] std::vector<LeftOutPass> left_out() const;
  // Of its buffers, in bytes.
  [[nodiscard]] std::uint64_t scratch_bytes() const;
  // Where each pixel's reflected colour came from (kSource… in frame.h), a word a pixel, of the frame executed last.
  [[nodiscard]] const Buffer& provenance() const { return provenance_; }

  [[nodiscard]] const ReflectionsOptions& options() const { return options_; }
  [[nodiscard]] const TraceVariant& trace_variant() const { return queue_.variant(); }
  // Programs that were compiled so far.
  [[nodiscard]] std::size_t program_count() const { return programs_.size(); }
  // Submits and waits: measures the kernels that trace on the rays of the frame recorded last, ray_count of them and at
  // least TraceQueue::kRaysToChoose, and goes on with the fastest. What has not begun after budget_ms is not measured:
  // false.
  Result<bool> choose_trace_variant(std::uint32_t ray_count, double budget_ms = INFINITY);

 private:
  struct Slot {
    Buffer frame;
    Buffer counters;  // read back
    BindingTable table;
    VkQueryPool queries = VK_NULL_HANDLE;
  };
  struct Scheduled {
    const Pass* pass = nullptr;
    Program* program = nullptr;
  };

  Reflections(Device& device, const ZoneSet& zones)
      : device_(device), zones_(zones), programs_(device), queue_(device, programs_) {}
  Status create_buffers(std::span<const gpu::MaterialEntry> materials);
  Status schedule();
  [[nodiscard]] Features features() const;
  void write_frame(const HostFrame& frame, Slot& slot);

  Device& device_;
  const ZoneSet& zones_;
  ReflectionsOptions options_;
  ProgramCache programs_;
  TraceQueue queue_;
  std::vector<Scheduled> scheduled_;
  gpu::FrameData frame_ = {};
  float smoothest_ = 1;  // of the materials' roughness
  Buffer materials_, hiz_, provenance_, pixels_;
  VkSampler sampler_ = VK_NULL_HANDLE;
  std::vector<Slot> slots_;
  std::uint32_t slot_ = 0;  // of the frame recorded last
};

}  // namespace zc
