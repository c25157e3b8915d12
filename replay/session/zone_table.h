// SPDX-License-Identifier: Apache-2.0
// Joins a streamer to a zone set: pages go to the pool, the rendered cut becomes zone table and draws.
// Borrows both. Threads: the frame's.
#pragma once

#include <span>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "runtime/scene/zone_set.h"
#include "streamer/streamer.h"

namespace zc {

class GpuPageSink final : public PageSink {
 public:
  explicit GpuPageSink(ZoneSet& zones, std::uint32_t max_zones) : zones_(zones), max_zones_(max_zones) {}
  Status create(std::uint64_t capacity_words) override { return zones_.create(capacity_words, max_zones_); }
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override {
    return zones_.upload(offset_words, page);
  }
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override {
    return zones_.move(from_words, to_words, count_words);
  }

 private:
  ZoneSet& zones_;
  std::uint32_t max_zones_;
};

// Whether the node's box lies wholly on the outer side of one of the view's five planes.
bool outside_view(const FrameCamera& camera, double aspect, const NodeRecord& node);

class ZoneTable {
 public:
  // tolerance: the streamer's; a zone that stands in for a finer one is marked coarse.
  ZoneTable(const Streamer& streamer, ZoneSet& zones, double tolerance)
      : streamer_(streamer), zones_(zones), tolerance_(tolerance) {}

  // After every advance(): uploads the table and the top level when something in them changed.
  Status update(const View& view);

  // Slot by slot, in the order of the pages in the pool.
  [[nodiscard]] std::span<const gpu::ZoneEntry> entries() const { return entries_; }

  // Zones of the rendered cut whose boxes touch the camera's view; all of them when `cull` is false.
  [[nodiscard]] std::vector<ZoneDraw> draws(const FrameCamera& camera, double aspect, bool cull) const;

 private:
  const Streamer& streamer_;
  ZoneSet& zones_;
  double tolerance_;
  std::vector<gpu::ZoneEntry> entries_;
};

}  // namespace zc
