// SPDX-License-Identifier: Apache-2.0
// What the device has of one set of zones: one pool with the pages, in front, and the top-level BVH over those that are
// shown, behind them; and the zone table. It is the page sink that draws: pages come and go through upload, move and
// remove; show says which of them are traced and drawn. The GPU must be idle during each of these calls, which it is
// between frames: every submission is waited for. All memory is taken by create() and counted by costs().
// Borrows the device. Threads: as the device. Fails when the driver refuses memory.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/device/resources.h"
#include "runtime/scene/top_level.h"
#include "runtime/scene/transfers.h"
#include "shaders/shared/scene.h"
#include "streamer/page_sink.h"

namespace zc {

struct ZoneSetOptions {
  // Recorded frames that may not have been executed when the next is recorded; what comes then waits for
  // record_transfers(). 0: the device is idle whenever a page comes, and everything is written at once.
  std::uint32_t frames_in_flight = 0;
  std::uint64_t staging_bytes = 64U << 10U;  // two or three pages: it counts against the cap
  bool use_staging = false;                  // even where the pool is mapped: to test the path of discrete GPUs
};

class ZoneSet final : public PageSink {
 public:
  explicit ZoneSet(Device& device, const ZoneSetOptions& options = {});

  [[nodiscard]] SinkCosts costs() const override;
  Status create(std::uint64_t capacity_words, std::uint64_t max_pages) override;
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override;
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override;
  void remove(std::uint64_t offset_words) override;
  Status show(std::span<const ShownPage> pages) override;

  // With frames_in_flight: records what came, moved and is shown since the last time. Before a frame's passes, in a
  // command buffer that is submitted before later ones.
  void record_transfers(VkCommandBuffer commands) { transfers_.record(commands); }
  // How often the staging memory was too small and the queue was waited for.
  [[nodiscard]] std::uint64_t transfer_waits() const { return transfers_.waits(); }

  [[nodiscard]] const Buffer& pool() const { return pool_; }
  [[nodiscard]] const Buffer& zones() const { return zones_; }
  // The pool as texels of one word and of four: all of it, or as much as the device can bind so.
  [[nodiscard]] const BufferView& texels() const { return texels_; }
  [[nodiscard]] const BufferView& texels4() const { return texels4_; }
  [[nodiscard]] bool all_as_texels() const { return all_as_texels_; }
  // The zone table: the slots that shaders see are places in it, in the order of the pages in the pool.
  [[nodiscard]] std::span<const gpu::ZoneEntry> shown() const { return entries_; }
  [[nodiscard]] std::uint32_t zone_count() const { return static_cast<std::uint32_t>(entries_.size()); }
  // Triangle positions in the page of the zone in a slot.
  [[nodiscard]] std::uint32_t triangle_count(std::uint32_t slot) const { return triangle_counts_.at(slot); }
  [[nodiscard]] std::uint32_t max_pages() const { return max_pages_; }
  // Nodes on the longest path of any top level over max_pages() pages.
  [[nodiscard]] std::uint32_t top_depth_bound() const { return top_level_depth_bound(max_pages_); }
  [[nodiscard]] std::uint32_t top_depth() const { return top_.depth(); }
  // The top level's root, in words of the pool.
  [[nodiscard]] std::uint32_t root_word() const { return root_word_; }
  // The first word behind the top level.
  [[nodiscard]] std::uint32_t end_word() const { return end_word_; }

 private:
  struct Resident {
    std::uint32_t page_word;
    std::uint32_t root;  // place in roots_
  };

  Status create_buffers(std::uint64_t pool_bytes);
  Status write(const Buffer& target, std::uint64_t offset_bytes, std::span<const std::byte> bytes);
  std::vector<Resident>::iterator first_from(std::uint64_t word);
  Status build_top_level();
  Status settle();

  Device& device_;
  const ZoneSetOptions options_;
  // The pool is written at once, where the device is idle between frames, and the top level is built in its place. Else
  // nodes of pages and of the top level are kept on the heap as well.
  const bool is_mapped_;
  Buffer pool_;
  Buffer zones_;
  Transfers transfers_;
  BufferView texels_;
  BufferView texels4_;
  bool all_as_texels_ = true;

  // Reserved for max_pages_.
  std::vector<Resident> residents_;  // by page word
  struct RootNodes {
    std::array<gpu::PageNode, 1 + gpu::kNodeWidth> nodes;  // the root and its children
  };
  std::vector<PageRoot> roots_;
  std::vector<RootNodes> root_nodes_;     // as in the pages; empty where the pool is mapped
  std::vector<gpu::PageNode> top_nodes_;  // likewise
  std::vector<std::uint32_t> free_roots_;
  std::vector<gpu::ZoneEntry> entries_;
  std::vector<std::uint32_t> triangle_counts_;  // by entry
  std::vector<TracedPage> traced_;
  TopLevelBuilder top_;
  std::uint32_t max_pages_ = 0;
  bool pages_changed_ = true;  // since the top level was built
  std::uint32_t root_word_ = 0;
  std::uint32_t end_word_ = 0;
};

}  // namespace zc
