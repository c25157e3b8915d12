// SPDX-License-Identifier: Apache-2.0
// The stand-in for an engine: draws a G-buffer from full-detail zones, lights it with sky and sun, has the reflections
// recorded, composites, and reads the picture back. What an engine does itself, and no part of the runtime.
// Owns: its images and pipelines. Borrows the device and both zone sets. Threads: as the device. Fails when the driver
// refuses.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/host/render_targets.h"
#include "runtime/reflections.h"

namespace zc {

enum class ReflectionMode {
  kScreenAndProxy,  // the screen first, proxies for what it does not resolve
  kProxy,           // every ray against the proxies
  kFull,            // every ray against the full detail
  kNone,            // mirrors show the sky
};

enum class DebugView { kProvenance, kBvh, kNormals, kDepth };

struct HostOptions {
  std::uint32_t width = 1280;
  std::uint32_t height = 720;
  ReflectionMode reflections = ReflectionMode::kScreenAndProxy;
  float sun_azimuth_deg = 145;  // clockwise from north (+y)
  float sun_elevation_deg = 38;
  bool sun_is_baked = false;  // the pages say for this sun what is lit and what is not
  float roughness_cut = 0.35F;
  std::uint32_t screen_steps = 256;
  std::uint32_t page_depth = gpu::kPageMaxDepth;  // deepest page that will be traced
  TraceVariant trace;                             // where it is not supported: nearest_fit()
  std::optional<bool> thread_per_pixel = {};      // see ReflectionsOptions
  bool leave_nothing_out = false;                 // schedule every pass of the reflections
  std::uint32_t step_limit = 0;                   // see ReflectionsOptions
  bool check_access = false;                      // see ReflectionsOptions
};

// A zone of the full detail, or of the proxies for kBvh, to draw: its slot and how much its page has.
struct ZoneDraw {
  std::uint32_t slot = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t node_count = 0;
};

// The passes of a frame as statistics name them: the host's own and those of the reflections.
inline constexpr std::array<const char*, 9> kPassNames = {"gbuffer", "hiz",   "classify", "ssr",      "compact",
                                                          "trace",   "shade", "filter",   "composite"};
inline constexpr std::size_t kPassCount = kPassNames.size();

struct FrameResult {
  gpu::Counters counters = {};
  std::array<double, kPassCount> pass_ms = {};
  double total_ms = 0;
};

class StandInHost {
 public:
  static Result<std::unique_ptr<StandInHost>> create(Device& device, const ZoneSet& proxies, const ZoneSet& full_detail,
                                                     std::span<const gpu::MaterialEntry> materials,
                                                     const HostOptions& options);
  StandInHost(const StandInHost&) = delete;
  StandInHost& operator=(const StandInHost&) = delete;
  ~StandInHost();

  // draws: zones of the full detail to rasterise, already culled.
  Result<FrameResult> render(const FrameCamera& camera, std::span<const ZoneDraw> draws);
  // Replaces the picture of the last frame. proxy_draws: the proxies' zones, for kBvh.
  Status draw_debug(DebugView view, std::span<const ZoneDraw> proxy_draws);
  // The picture: width × height RGBA8 (sRGB), top row first; valid until the next call.
  [[nodiscard]] std::span<const std::byte> pixels() const;

  // Other settings of the same size; compiles only what is new.
  Status reconfigure(const HostOptions& options);

  // Null where nothing is reflected.
  [[nodiscard]] Reflections* reflections() { return reflections_.get(); }
  [[nodiscard]] const TraceVariant& trace_variant() const;
  // As Reflections: of the last frame's rays.
  Result<bool> choose_trace_variant(std::uint32_t ray_count, double budget_ms = INFINITY);
  // What scene and settings leave out of a frame, a line each.
  [[nodiscard]] std::vector<LeftOutPass> left_out() const;

 private:
  StandInHost(Device& device, const ZoneSet& proxies, const ZoneSet& full_detail, const HostOptions& options)
      : device_(device), proxies_(proxies), full_detail_(full_detail), options_(options), programs_(device) {}
  Status create(std::span<const gpu::MaterialEntry> materials);
  Status create_programs();
  [[nodiscard]] ReflectionsOptions reflections_options() const;
  Status create_reflections();
  void write_frame(const FrameCamera& camera);
  void dispatch_pixels(VkCommandBuffer c, Program& program, const gpu::PassConstants* constants = nullptr);
  void record_gbuffer(VkCommandBuffer c, std::span<const ZoneDraw> draws);
  void record_lines(VkCommandBuffer c, std::span<const ZoneDraw> draws);
  void record_readback(VkCommandBuffer c) const;
  void stamp(VkCommandBuffer c, std::uint32_t index) const;

  Device& device_;
  const ZoneSet& proxies_;
  const ZoneSet& full_detail_;
  HostOptions options_;
  std::vector<gpu::MaterialEntry> material_entries_;
  ProgramCache programs_;
  RenderTargets targets_;
  gpu::FrameData frame_ = {};
  FrameCamera camera_, previous_camera_;
  FrameSun sun_;
  Buffer frame_buffer_, materials_, output_, readback_;
  Buffer counters_;       // of access checks in its own passes
  Buffer no_provenance_;  // of frames that reflect nothing
  BindingTable detail_table_, proxy_table_;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  std::unique_ptr<Program> draw_zone_, draw_lines_;
  Program* light_ = nullptr;
  Program* composite_ = nullptr;
  Program* debug_ = nullptr;
  std::unique_ptr<Reflections> reflections_;
};

}  // namespace zc
