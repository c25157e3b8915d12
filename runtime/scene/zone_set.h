// SPDX-License-Identifier: Apache-2.0
// What the GPU holds of one set of zones: one pool with the pages, in front, and the top-level BVH over those that are
// traced, behind them; and the zone table. Pages come and go through upload and move; set_zones then says which of them
// are traced. The GPU must be idle, which it is between frames: every submission is waited for. Borrows the device.
// Threads: as the device. Fails when the driver refuses memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/device/resources.h"
#include "runtime/scene/top_level.h"
#include "shaders/shared/scene.h"

namespace zc {

class ZoneSet {
 public:
  // use_staging: copy through a staging buffer even where the pool is mapped (tests the path of discrete GPUs).
  explicit ZoneSet(Device& device, bool use_staging = false) : device_(device), use_staging_(use_staging) {}

  // Takes the pool's memory, once, and room for max_zones zones.
  Status create(std::uint64_t capacity_words, std::uint32_t max_zones);
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page);
  // As memmove: ranges may overlap.
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words);
  // In the order of their pages in the pool; the slots that shaders see are positions in `zones`.
  Status set_zones(std::span<const gpu::ZoneEntry> zones);

  [[nodiscard]] const Buffer& pool() const { return pool_; }
  [[nodiscard]] const Buffer& zones() const { return zones_; }
  // The pool as texels of one word and of four.
  [[nodiscard]] const BufferView& texels() const { return texels_; }
  [[nodiscard]] const BufferView& texels4() const { return texels4_; }
  [[nodiscard]] std::uint32_t zone_count() const { return zone_count_; }
  // Triangle positions in the page of the zone in a slot.
  [[nodiscard]] std::uint32_t triangle_count(std::uint32_t slot) const { return triangle_counts_.at(slot); }
  [[nodiscard]] std::uint32_t top_depth() const { return top_.depth(); }
  // Nodes on the longest path of any top level over as many pages as were planned for.
  [[nodiscard]] std::uint32_t top_depth_bound() const { return top_level_depth_bound(max_zones_); }
  // The top level's root, in words of the pool.
  [[nodiscard]] std::uint32_t root_word() const { return root_word_; }
  // The first word behind the top level.
  [[nodiscard]] std::uint32_t end_word() const { return end_word_; }

 private:
  Status write(const Buffer& target, std::uint64_t offset_bytes, std::span<const std::byte> bytes);

  Device& device_;
  bool use_staging_;
  Buffer pool_;
  Buffer zones_;
  Buffer staging_;
  BufferView texels_;
  BufferView texels4_;
  struct Resident {
    std::uint64_t page_word;
    std::unique_ptr<PageRoot> root;
  };
  std::vector<Resident>::iterator first_from(std::uint64_t word);

  std::vector<Resident> residents_;  // by page word
  std::vector<TracedPage> traced_;
  TopLevelBuilder top_;
  std::vector<std::uint32_t> triangle_counts_;
  std::uint32_t root_word_ = 0;
  std::uint32_t end_word_ = 0;
  std::uint32_t zone_count_ = 0;
  std::uint32_t max_zones_ = 1;
};

}  // namespace zc
