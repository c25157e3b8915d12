// SPDX-License-Identifier: Apache-2.0
// Draws one frame: the host's G-buffer from full-detail zones, screen-space reflections, and where they find nothing a
// ray against the resident proxies (Fredriksson & Scott 2016, "the thesis").
// Borrows the device and both zone sets. Threads: as the device. Fails when the driver refuses.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "runtime/device/pipelines.h"
#include "runtime/scene/zone_set.h"
#include "runtime/trace_variant.h"
#include "shaders/shared/page.h"

namespace zc {

enum class ReflectionMode {
  kScreenAndProxy,  // SSR first, proxies for what it does not resolve
  kProxy,           // every ray against the proxies
  kFull,            // every ray against the host's full detail
  kNone,            // mirrors show the sky
};

enum class DebugView { kProvenance, kBvh, kNormals, kDepth };

// The kernels that trace the proxies and say what they hit, where those are not pages of ours: `zonecast bench trace`
// measures other layouts with everything else as it is. Empty: ours.
struct LayoutKernels {
  std::span<const std::uint32_t> packets, rays, resolve;
};

struct RendererOptions {
  std::uint32_t width = 1280;
  std::uint32_t height = 720;
  ReflectionMode reflections = ReflectionMode::kScreenAndProxy;
  float sun_azimuth_deg = 145;  // clockwise from north (+y)
  float sun_elevation_deg = 38;
  bool sun_is_baked = false;    // the pages say for this sun what is lit and what is not
  float roughness_cut = 0.35F;  // rougher surfaces do not mirror
  std::uint32_t screen_steps = 256;
  std::uint32_t page_depth = gpu::kPageMaxDepth;  // deepest page that will be traced
  std::uint32_t max_zones = 1;                    // most zones ever resident in one set
  bool pools_as_texels = true;                    // the device can bind the whole of both sets' pools as texels
  TraceVariant trace;                             // where it does not fit: nearest_fit()
  std::uint32_t step_limit = 0;                   // nodes that a ray may visit; 0: step_limit() of the device
  bool check_access = false;                      // count reads outside the traced pages, and divert them: for tests
  LayoutKernels proxy_kernels = {};
};

struct RenderCamera {
  std::array<std::int32_t, 3> lattice = {};     // lattice point that the frame is relative to
  double step_m = 1.0 / 256;                    // lattice step
  glm::vec3 eye = {};                           // metres from that point
  glm::vec3 right = {}, up = {}, forward = {};  // orthonormal
  float fov_y_deg = 60;
  float ray_length_m = 20000;  // no ray needs to go further
};

// A zone of the host set to draw: its slot and how many triangles its page has.
struct ZoneDraw {
  std::uint32_t slot = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t node_count = 0;
};

enum class Pass { kGbuffer, kHiz, kClassify, kSsr, kCompact, kTrace, kShade, kFilter, kComposite };
inline constexpr std::size_t kPassCount = 9;

struct FrameResult {
  gpu::Counters counters = {};
  std::array<double, kPassCount> pass_ms = {};
  double total_ms = 0;
};

struct TraceOptions {
  bool host = false;     // against the host set instead of the proxies
  bool any_hit = false;  // only whether something is hit: of a hit it is open which, and how far
};

struct TracedHit {
  float t = 0;                  // metres
  std::uint32_t page_word = 0;  // the page's first word in the pool, or gpu::kHitNone / kHitLost
  std::uint32_t triangle = 0;   // position in that page
};

// What tracing with these options may take on this device.
TraceLimits trace_limits(const Device& device, const RendererOptions& options);

class Renderer {
 public:
  static constexpr std::uint32_t kRaysToChoose = 4096;  // fewer do not tell one kernel from another

  static Result<std::unique_ptr<Renderer>> create(Device& device, const ZoneSet& proxies, const ZoneSet& host,
                                                  std::span<const gpu::MaterialEntry> materials,
                                                  const RendererOptions& options);
  ~Renderer();

  // host_draws: zones of the host set to rasterise, already culled.
  Result<FrameResult> render(const RenderCamera& camera, std::span<const ZoneDraw> host_draws);
  // Replaces the picture of the last frame. proxy_draws: the proxy set's zones, for kBvh.
  Status draw_debug(DebugView view, std::span<const ZoneDraw> proxy_draws);
  // The picture: width × height RGBA8 (sRGB), top row first; valid until the next call.
  [[nodiscard]] std::span<const std::byte> pixels() const;

  // Hits of rays (positions relative to camera_lattice) up to the camera's ray_length_m: for tests and benchmarks. At
  // most width × height rays at a time.
  Result<std::vector<TracedHit>> trace(const RenderCamera& camera, std::span<const gpu::RayTask> rays,
                                       const TraceOptions& options = {}, double* milliseconds = nullptr);
  // What the last trace() or render() counted.
  [[nodiscard]] gpu::Counters counters() const;

  // The kernels in use.
  [[nodiscard]] const TraceVariant& trace_variant() const { return options_.trace; }
  // Measures kernels on the rays that the last render() or trace() queued, `ray_count` of them and at least
  // kRaysToChoose, and goes on with the fastest. What has not begun after budget_ms is not measured: false. The queue,
  // hits and counters are of no use afterwards.
  Result<bool> choose_trace_variant(std::uint32_t ray_count, bool host, double budget_ms = INFINITY);

 private:
  Renderer(Device& device, const ZoneSet& proxies, const ZoneSet& host, const RendererOptions& options)
      : device_(device), proxies_(proxies), host_(host), options_(options), layout_(device) {}
  Status create_buffers(std::span<const gpu::MaterialEntry> materials);
  Status create_targets();
  Status create_pipelines();
  void write_frame(const RenderCamera& camera);
  void record_gbuffer(VkCommandBuffer c, std::span<const ZoneDraw> draws) const;
  void record_lines(VkCommandBuffer c, std::span<const ZoneDraw> draws) const;
  void record_readback(VkCommandBuffer c) const;
  void bind(VkCommandBuffer c, const Pipeline& pipeline) const;
  void dispatch_pixels(VkCommandBuffer c, const Pipeline& pipeline, std::uint32_t width, std::uint32_t height,
                       const gpu::PassConstants& constants = {}) const;
  // One variant of what traces the ray queue against one set.
  struct TraceKernels {
    Pipeline size, packets, rays;  // without packets: rays one by one
  };
  [[nodiscard]] LayoutKernels layout_kernels(bool host) const;
  [[nodiscard]] PassVariant pass_variant(const TraceVariant& trace, bool host) const;
  Result<TraceKernels> create_kernels(const TraceVariant& trace, const TraceOptions& options) const;
  // The kernels in use and the pipeline that resolves hits for trace(), made when they are first asked for.
  Result<const TraceKernels*> kernels(const TraceOptions& options);
  Status create_resolve(bool host);
  // The ray queue, in packets first.
  void record_trace(VkCommandBuffer c, const TraceKernels& kernels) const;
  // The same for the first rays of the queue, by itself; returns milliseconds.
  Result<double> trace_queue(const TraceKernels& kernels, std::uint32_t ray_count);
  // Brings runs of rays from all over the queue to its front.
  Status thin_queue(std::uint32_t ray_count, std::uint32_t runs);
  void dispatch_indirect(VkCommandBuffer c, const Pipeline& pipeline, std::size_t offset_bytes) const;
  void stamp(VkCommandBuffer c, std::uint32_t index) const;
  Status read_stamps(std::span<std::uint64_t> ticks) const;  // the first ones; zeros where the queue has none

  Device& device_;
  const ZoneSet& proxies_;
  const ZoneSet& host_;
  RendererOptions options_;
  PassLayout layout_;
  gpu::FrameData frame_ = {};

  Buffer frame_buffer_, materials_, hiz_, lit_, reflection_, provenance_, pixel_list_, rays_, hits_, fallback_rays_,
      counters_, output_;
  Buffer readback_, counters_readback_;
  BufferView ray_texels_;
  Image depth_, surface_, overlay_;
  VkRenderPass gbuffer_pass_ = VK_NULL_HANDLE;
  VkRenderPass overlay_pass_ = VK_NULL_HANDLE;
  VkFramebuffer gbuffer_target_ = VK_NULL_HANDLE;
  VkFramebuffer overlay_target_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  Pipeline draw_zone_, draw_lines_, light_, reduce_, classify_, march_, resolve_proxies_, resolve_host_, shade_,
      composite_, debug_;
  std::optional<TraceKernels> kernels_proxies_, kernels_host_, any_hit_proxies_, any_hit_host_;
};

}  // namespace zc
