// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/zonecast_engine.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "replay/bench/engines/gpu_engine.h"
#include "replay/bench/engines/parallel_chunks.h"
#include "replay/bench/engines/plain_layout.h"
#include "replay/bench/engines/stopwatch.h"
#include "replay/bench/engines/zone_mesh.h"
#include "runtime/scene/zone_set.h"
#include "runtime/tracer.h"
#include "spirv/bench.h"

namespace zc::bench {
namespace {

constexpr float kFarthestM = 1e30F;

class ZonecastEngine final : public TraceEngine {
 public:
  ZonecastEngine(Device& device, ZonecastOptions options, PageBuilder builder, unsigned threads)
      : device_(device),
        options_(std::move(options)),
        builder_(std::move(builder)),
        threads_(threads),
        zones_(device),
        plain_zones_(device) {}
  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] BuildFigures figures() const override { return figures_; }

  Status build(const BenchScene& scene) override {
    scene_ = &scene;
    ZC_ASSIGN(std::vector<ZonePage> pages, build_pages(scene));
    std::uint64_t words = 0;
    for (const ZonePage& page : pages) {
      words += page.words.size();
      page_depth_ = std::max(page_depth_, page_root(page.words).depth);
    }
    const auto count = static_cast<std::uint32_t>(pages.size());
    ZC_TRY(zones_.create(words, count));
    std::vector<ShownPage> shown;
    std::uint32_t at = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      ZC_TRY(zones_.upload(at, pages[i].words));
      shown.push_back({at, i, false});
      at += static_cast<std::uint32_t>(pages[i].words.size());
      order_.push_back(std::move(pages[i].order));
    }
    const Stopwatch watch;
    ZC_TRY(zones_.show(shown));
    figures_.build_ms += watch.ms();
    figures_.bytes = 4 * (words + zones_.end_word() - zones_.root_word());
    return options_.plain ? build_plain() : Status{};
  }

  Result<double> trace(std::span<const BenchRay> rays, std::span<BenchHit> hits) override {
    if (tracer_ == nullptr || max_rays_ < rays.size()) {
      const ZoneSet& traced = options_.plain ? plain_zones_ : zones_;
      TracerOptions options;
      options.max_rays = max_rays_ = static_cast<std::uint32_t>(rays.size());
      options.page_depth = page_depth_ + zones_.top_depth_bound();  // the plain pool has no top level of its own
      options.trace = options_.variant;
      const TraceLimits limits =
          trace_limits(device_, options.page_depth, traced.top_depth_bound(), traced.all_as_texels());
      if (const auto why_not = unsupported_reason(options.trace, limits); !why_not.empty())
        return Error{ErrorCode::kUnsupported, std::string(why_not)};
      if (options_.plain)
        options.kernels = {shader::trace_plain_packets(),
                           packets() ? shader::trace_plain_children() : shader::trace_plain_rays(),
                           shader::resolve_plain()};
      ZC_ASSIGN(tracer_, Tracer::create(device_, traced, options));
    }
    FrameCamera camera;
    camera.step_m = scene_->step_m;
    camera.ray_length_m = kFarthestM;
    std::vector<gpu::RayTask> tasks(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const BenchRay& r = rays[i];
      tasks[i] = {r.ox, r.oy, r.oz, 0, r.dx, r.dy, r.dz, gpu::kNoSurface};
    }
    double milliseconds = 0;
    ZC_ASSIGN(const std::vector<TracedHit> records, tracer_->trace(camera, tasks, options_.any_hit, &milliseconds));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      TracedHit hit = records[i];
      if (hit.page_word == gpu::kHitLost) return Error{ErrorCode::kDevice, "ray " + std::to_string(i) + " was lost"};
      hits[i] = {};
      if (hit.page_word == gpu::kHitNone) continue;
      if (options_.plain) {
        const PlainTriangle& triangle = plain_triangles_.at(hit.triangle - plain_first_);
        hit.page_word = triangle.page_word;
        hit.triangle = triangle.position;
      }
      const auto zone = std::ranges::lower_bound(zones_.shown(), hit.page_word, {}, &gpu::ZoneEntry::page_word);
      ZC_CHECK(zone != zones_.shown().end() && zone->page_word == hit.page_word);
      hits[i] = {hit.t, scene_->zones[zone->node].first + order_[zone->node].at(hit.triangle)};
    }
    return milliseconds;
  }

 private:
  Result<std::vector<ZonePage>> build_pages(const BenchScene& scene) {
    std::vector<ZonePage> pages(scene.zones.size());
    std::vector<NodeRecord> nodes(pages.size());
    std::vector<ZoneMesh> meshes;
    for (std::size_t i = 0; i < pages.size(); ++i) meshes.push_back(weld_zone(scene, scene.zones[i], nodes[i]));
    std::vector<Status> results(pages.size());
    const Stopwatch watch;
    parallel_chunks<1>(pages.size(), threads_, [&](std::size_t i, std::size_t /*end*/) {
      Result<ZonePage> page = builder_(meshes[i], nodes[i]);
      if (page) {
        pages[i] = *std::move(page);
      } else {
        results[i] = std::move(page).error();
      }
    });
    figures_.build_ms = watch.ms();
    for (Status& result : results) ZC_TRY(std::move(result));
    return pages;
  }

  [[nodiscard]] bool packets() const { return options_.variant.rays_per_lane > 0; }

  // From the pool as the device has it.
  Status build_plain() {
    std::vector<std::uint32_t> pool(zones_.end_word());
    ZC_TRY(read_buffer(device_, zones_.pool(), std::as_writable_bytes(std::span(pool))));
    const Stopwatch watch;
    PlainPool plain =
        make_plain_pool(pool, zones_.root_word(), packets() ? PlainNodes::kByChild : PlainNodes::kByPlane);
    figures_.build_ms += watch.ms();
    figures_.bytes = 4 * plain.words.size();
    plain_first_ = plain.first_triangle;
    plain_triangles_ = std::move(plain.triangles);
    ZC_TRY(plain_zones_.create(plain.words.size(), 1));
    return write_buffer(device_, plain_zones_.pool(), std::as_bytes(std::span(plain.words)));
  }

  Device& device_;
  ZonecastOptions options_;
  PageBuilder builder_;
  unsigned threads_;
  const BenchScene* scene_ = nullptr;
  ZoneSet zones_;
  ZoneSet plain_zones_;  // a pool alone
  std::vector<PlainTriangle> plain_triangles_;
  std::uint32_t plain_first_ = 0;
  std::vector<std::vector<std::uint32_t>> order_;  // by zone
  std::unique_ptr<Tracer> tracer_;
  std::uint32_t max_rays_ = 0;
  std::uint32_t page_depth_ = 1;
  BuildFigures figures_;
};

}  // namespace

std::unique_ptr<TraceEngine> make_zonecast_engine(Device& device, ZonecastOptions options, PageBuilder builder,
                                                  unsigned threads) {
  return std::make_unique<ZonecastEngine>(device, std::move(options), std::move(builder), threads);
}

}  // namespace zc::bench
