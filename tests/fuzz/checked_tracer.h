// SPDX-License-Identifier: Apache-2.0
// Traces pages on the device by the kernels of the renderer, with every access checked, under validation layers and
// robust buffer access: one ray at a time and in packets, through texels and through the storage buffer.
// Units: lattice steps, metres in rays. Threads: one at a time.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "runtime/scene/zone_set.h"
#include "runtime/tracer.h"
#include "streamer/world_format/page_view.h"

namespace zc::test {

struct TraceSums {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t lost = 0;            // gave up: kHitLost
  std::uint64_t alone = 0;           // rays that packets left to fallback rays
  std::uint64_t out_of_page = 0;     // accesses outside the pages and the top level
  std::uint64_t unknown_places = 0;  // hits on a page or a triangle that is not there
};

struct TracedOne {
  std::uint32_t word = 0;  // where it lies in the pool
  std::span<const std::uint32_t> page;
};

class CheckedTracer {
 public:
  static constexpr std::uint32_t kSide = 16;
  static constexpr std::uint32_t kRays = kSide * kSide;
  static constexpr std::array<TraceVariant, 4> kKernels = {{
      {.rays_per_lane = 0, .pool_path = gpu::kPoolTexels},
      {.rays_per_lane = 0, .pool_path = gpu::kPoolStorage, .stack_shared = true},
      {.rays_per_lane = 4, .pool_path = gpu::kPoolTexels},
      {.rays_per_lane = 4, .pool_path = gpu::kPoolStorage},
  }};
  static constexpr std::uint32_t kPageDepth = 10;

  Status open(std::uint64_t pool_words, std::uint32_t material_count) {
    DeviceOptions options;
    options.validation = true;
    ZC_ASSIGN(device_, Device::create(options));
    proxies_.emplace(*device_);
    host_.emplace(*device_);
    ZC_TRY(proxies_->create(pool_words, 2));
    ZC_TRY(host_->create(pool_words, 2));
    // What lies between the pages leads nowhere good.
    const std::vector<std::uint32_t> wild(pool_words, 0xFFFFFFF1U);
    std::memcpy(proxies_->pool().mapped().data(), wild.data(), 4 * wild.size());
    std::memcpy(host_->pool().mapped().data(), wild.data(), 4 * wild.size());
    const std::vector<gpu::MaterialEntry> mirrors(material_count, {0.5F, 0.5F, 0.5F, 0.01F, 1, 0, 0, 0});
    for (std::size_t i = 0; i < kKernels.size(); ++i) {
      HostOptions renderer;
      renderer.width = renderer.height = kSide;
      renderer.reflections = ReflectionMode::kProxy;
      renderer.page_depth = kPageDepth;
      renderer.trace = kKernels[i];
      renderer.check_access = true;
      ZC_ASSIGN(renderers_[i], StandInHost::create(*device_, *proxies_, *host_, mirrors, renderer));
      TracerOptions tracer;
      tracer.max_rays = kRays;
      tracer.page_depth = kPageDepth;
      tracer.trace = kKernels[i];
      tracer.check_access = true;
      ZC_ASSIGN(tracers_[i], Tracer::create(*device_, *proxies_, tracer));
    }
    return {};
  }

  [[nodiscard]] const Device& device() const { return *device_; }

  // The pages to trace from now on, in the order of their words, in both sets.
  Status show(std::span<const TracedOne> pages) {
    std::vector<ShownPage> shown;
    for (const TracedOne& one : pages) shown.push_back({one.word, 0, false});
    for (ZoneSet* set : {&*proxies_, &*host_}) {
      for (const TracedOne& one : pages_) set->remove(one.word);
      for (const TracedOne& one : pages) ZC_TRY(set->upload(one.word, one.page));
      ZC_TRY(set->show(shown));
    }
    pages_.assign(pages.begin(), pages.end());
    return {};
  }

  Result<TraceSums> trace(std::size_t kernel, const FrameCamera& camera, std::span<const gpu::RayTask> rays) {
    ZC_ASSIGN(const auto hits, tracers_[kernel]->trace(camera, rays));
    const gpu::Counters counters = tracers_[kernel]->counters();
    TraceSums sums;
    sums.rays = rays.size();
    sums.alone = counters.fallback_count;
    sums.out_of_page = counters.out_of_page;
    for (const TracedHit& hit : hits) {
      if (hit.page_word == gpu::kHitNone) continue;
      hit.page_word == gpu::kHitLost ? ++sums.lost : ++sums.hits;
      if (hit.page_word != gpu::kHitLost && !is_there(hit)) ++sums.unknown_places;
    }
    return sums;
  }

  // All passes of a frame: the page is drawn, lit, mirrored in the other one and shading_normal.
  Result<TraceSums> render(std::size_t kernel, const FrameCamera& camera) {
    std::vector<ZoneDraw> draws;
    for (std::uint32_t slot = 0; slot < pages_.size(); ++slot)
      draws.push_back({slot, host_->triangle_count(slot), PageView(pages_[slot].page).header().node_count});
    ZC_ASSIGN(const FrameResult frame, renderers_[kernel]->render(camera, draws));
    TraceSums sums;
    sums.rays = frame.counters.ray_count;
    sums.hits = frame.counters.rays_proxy + frame.counters.rays_proxy_coarse;
    sums.lost = frame.counters.rays_lost;
    sums.alone = frame.counters.fallback_count;
    sums.out_of_page = frame.counters.out_of_page;
    return sums;
  }

 private:
  [[nodiscard]] bool is_there(const TracedHit& hit) const {
    for (const TracedOne& one : pages_)
      if (one.word == hit.page_word) return hit.triangle < PageView(one.page).header().triangle_count;
    return false;
  }

  std::unique_ptr<Device> device_;
  std::optional<ZoneSet> proxies_, host_;
  std::array<std::unique_ptr<StandInHost>, kKernels.size()> renderers_;
  std::array<std::unique_ptr<Tracer>, kKernels.size()> tracers_;
  std::vector<TracedOne> pages_;
};

}  // namespace zc::test
