// SPDX-License-Identifier: GPL-3.0-or-later
// A scene baked, streamed whole and ready to render or trace, for tests that compare the GPU with the truth.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "baker/bake.h"
#include "replay/scene/paged_scene.h"
#include "replay/scene/rendered_scene.h"
#include "runtime/tracer.h"
#include "streamer/streamer.h"
#include "streamer/world_format/page_view.h"

namespace zc::test {

// Hands pages on, but for the error that their clusters name.
class ErrorClaim final : public PageSink {
 public:
  ErrorClaim(PageSink& sink, std::optional<float> error_m) : sink_(sink), error_m_(error_m) {}

  [[nodiscard]] SinkCosts costs() const override { return sink_.costs(); }
  Status create(std::uint64_t capacity_words, std::uint64_t max_pages) override {
    return sink_.create(capacity_words, max_pages);
  }
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override {
    if (!error_m_) return sink_.upload(offset_words, page);
    std::vector<std::uint32_t> changed(page.begin(), page.end());
    const gpu::PageHeader header = PageView(page).header();
    for (std::uint32_t c = 0; c < header.cluster_count; ++c) {
      const std::size_t cluster = page[header.entries_offset_words + c * gpu::kClusterEntryWords + 1];
      changed[cluster + offsetof(gpu::ClusterHeader, error_m) / 4] = std::bit_cast<std::uint32_t>(*error_m_);
    }
    return sink_.upload(offset_words, changed);
  }
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override {
    return sink_.move(from_words, to_words, count_words);
  }
  void remove(std::uint64_t offset_words) override { sink_.remove(offset_words); }
  Status show(std::span<const ShownPage> pages) override { return sink_.show(pages); }

 private:
  PageSink& sink_;
  std::optional<float> error_m_;
};

class RenderedWorld {
 public:
  RenderedWorld() = default;
  RenderedWorld(const RenderedWorld&) = delete;
  RenderedWorld& operator=(const RenderedWorld&) = delete;
  ~RenderedWorld() {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }

  // Every zone resident at its finest proxy; the host set has the full detail.
  // claimed_error_m: the error that the proxies' pages name instead of what was measured.
  Status open(Scene scene, const BakeOptions& bake, HostOptions options,
              std::optional<float> claimed_error_m = std::nullopt) {
    std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-numerics-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) return Error{ErrorCode::kIo, "no temporary folder", pattern};
    folder_ = pattern;
    ZC_ASSIGN([[maybe_unused]] const BakeReport baked, bake_world(std::move(scene), 0, bake, folder_ / "world"));
    ZC_ASSIGN(source_, open_directory_source(folder_ / "world"));
    DeviceOptions device;
    device.validation = true;
    ZC_ASSIGN(device_, Device::create(device));
    proxies_.emplace(*device_);
    host_.emplace(*device_, ZoneSetOptions{.use_staging = true});  // the path of discrete GPUs is under test as well
    claim_.emplace(proxies_->zones(), claimed_error_m);
    StreamerOptions paging;
    paging.cap_bytes = 128U << 20U;
    paging.tolerance = 1e-9;
    ZC_TRY(proxies_->open_through(*claim_, *source_, folder_ / "world", paging));
    paging.include_detail = true;
    ZC_TRY(host_->open(*source_, folder_ / "world", paging));
    const View view{{0, 0, 0}};
    ZC_TRY(proxies_->streamer().advance(std::span(&view, 1), 0));
    ZC_TRY(host_->streamer().advance(std::span(&view, 1), 0));
    return remake_renderer(options);
  }

  // With other options, over the same zones.
  Status remake_renderer(const HostOptions& options) {
    ZC_ASSIGN(rendered_, RenderedScene::create(*device_, *proxies_, *host_, options));
    return {};
  }

  Status make_tracer(std::uint32_t max_rays, std::uint32_t page_depth, const TraceVariant& variant) {
    TracerOptions options;
    options.max_rays = max_rays;
    options.page_depth = page_depth;
    options.trace = variant;
    ZC_ASSIGN(tracer_, Tracer::create(*device_, proxies_->zones(), options));
    return {};
  }

  // A camera at a CRS position. The basis is taken as it is, mirrored ones included.
  [[nodiscard]] FrameCamera camera(const glm::dvec3& eye, const glm::vec3& right, const glm::vec3& up,
                                   const glm::vec3& forward) const {
    FrameCamera camera;
    place_eye(camera, eye, index().header.anchor, index().step_m());
    camera.right = right;
    camera.up = up;
    camera.forward = forward;
    camera.ray_length_m = 1e5F;
    return camera;
  }

  Result<FrameResult> render(const FrameCamera& camera) { return rendered_->draw(camera, /*cull=*/false); }

  [[nodiscard]] IndexView index() const { return proxies_->index(); }
  [[nodiscard]] Source& source() { return *source_; }
  [[nodiscard]] const Streamer& streamer() const { return proxies_->streamer(); }
  // The proxies that are traced, by slot.
  [[nodiscard]] std::span<const gpu::ZoneEntry> proxy_zones() const { return proxies_->zones().shown(); }
  [[nodiscard]] StandInHost& renderer() { return rendered_->host(); }
  [[nodiscard]] Tracer& tracer() { return *tracer_; }
  [[nodiscard]] const Device& device() const { return *device_; }

 private:
  std::filesystem::path folder_;
  std::unique_ptr<Source> source_;
  std::unique_ptr<Device> device_;
  std::optional<ErrorClaim> claim_;
  std::optional<PagedScene> proxies_, host_;
  std::unique_ptr<RenderedScene> rendered_;
  std::unique_ptr<Tracer> tracer_;
};

}  // namespace zc::test
