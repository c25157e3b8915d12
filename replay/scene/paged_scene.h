// SPDX-License-Identifier: Apache-2.0
// A world's zones, paged into a set that can be drawn or traced; without a device onto the heap, which costs nothing
// but its pool. Errors name the world. Owns the set and the streamer; borrows the device and the source. Threads: as
// Streamer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "base/check.h"
#include "runtime/scene/zone_set.h"
#include "streamer/paging/heap_page_sink.h"
#include "streamer/streamer.h"

namespace zc {

// A device whose pool the CPU does not see takes staging memory, so much that a frame's pages wait for its queue once.
inline ZoneSetOptions staging_for(const Device& device, std::uint64_t cap_bytes) {
  ZoneSetOptions options;
  if (!device.is_cpu()) options.staging_bytes = std::clamp<std::uint64_t>(cap_bytes / 16, 64U << 10U, 8U << 20U);
  return options;
}

class PagedScene {
 public:
  PagedScene();
  explicit PagedScene(Device& device, const ZoneSetOptions& options = {});
  PagedScene(const PagedScene&) = delete;
  PagedScene& operator=(const PagedScene&) = delete;
  ~PagedScene() = default;

  // Once, before anything else. world: where the source lies, for errors. Fails as Streamer::open().
  Status open(Source& source, const std::filesystem::path& world, const StreamerOptions& options);
  // The same; pages reach zones() through a sink that may change them.
  Status open_through(PageSink& sink, Source& source, const std::filesystem::path& world,
                      const StreamerOptions& options);

  // Streamer::advance(); errors name the world.
  Status advance(std::span<const View> views, double time_s);
  [[nodiscard]] Streamer& streamer() { return *streamer_; }
  [[nodiscard]] const Streamer& streamer() const { return *streamer_; }
  [[nodiscard]] IndexView index() const { return streamer_->index(); }
  // Of a scene on a device.
  [[nodiscard]] ZoneSet& zones() {
    ZC_CHECK(zones_.has_value());
    return *zones_;
  }
  [[nodiscard]] const ZoneSet& zones() const {
    ZC_CHECK(zones_.has_value());
    return *zones_;
  }

 private:
  std::optional<ZoneSet> zones_;
  std::optional<HeapPageSink> heap_;
  std::filesystem::path world_;
  std::unique_ptr<Streamer> streamer_;
};

}  // namespace zc
