// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/page_pool.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "base/check.h"
#include "streamer/paging/selection.h"

namespace zc {

PagePool::PagePool(const IndexView& index, PageSink& sink, std::uint64_t pool_words, std::uint64_t pages)
    : index_(index), sink_(sink), pool_(pool_words), nodes_(index), offsets_(index.nodes.size()) {
  ZC_CHECK(pool_words / kPageAlignWords <= std::numeric_limits<std::uint32_t>::max());
  // Reserved to their largest, so that none ever grows beyond what the ledger counts.
  for (std::vector<std::uint32_t>* list : {&residents_, &cut_, &previous_cut_}) list->reserve(pages);
  cut_offsets_.reserve(pages);
}

std::uint64_t PagePool::page_words(std::uint32_t node) const { return index_.nodes[node].page_bytes / 4; }

bool PagePool::has_room_for(std::uint32_t node) const { return pool_.free_words() >= aligned_words(page_words(node)); }

std::uint64_t PagePool::offset_words(std::uint32_t node) const {
  ZC_CHECK(nodes_.resident(node));
  return std::uint64_t{offsets_[node]} * kPageAlignWords;
}

Status PagePool::add(std::uint32_t node, std::span<const std::uint32_t> page) {
  ZC_CHECK(page.size() == page_words(node) && has_room_for(node));
  std::optional<std::uint64_t> offset = pool_.allocate(page.size());
  if (!offset) {
    ZC_TRY(compact(aligned_words(page.size())));
    offset = pool_.allocate(page.size());
  }
  ZC_CHECK(offset);
  ZC_TRY(sink_.upload(*offset, page));
  offsets_[node] = static_cast<std::uint32_t>(*offset / kPageAlignWords);
  nodes_.add(node);
  residents_.push_back(node);
  page_bytes_ += index_.nodes[node].page_bytes;
  changed_ = true;
  return {};
}

void PagePool::remove(std::uint32_t node) {
  sink_.remove(offset_words(node));
  pool_.free(offset_words(node), page_words(node));
  nodes_.remove(node);
  const auto at = std::find(residents_.begin(), residents_.end(), node);
  *at = residents_.back();
  residents_.pop_back();
  page_bytes_ -= index_.nodes[node].page_bytes;
  changed_ = true;
}

// Slides the pages of one stretch of the pool down: the stretch whose holes are large enough together and whose pages
// are the fewest words.
Status PagePool::compact(std::uint64_t words) {
  std::sort(residents_.begin(), residents_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return offsets_[a] < offsets_[b]; });
  const auto begin_of = [&](std::size_t i) {
    return i < residents_.size() ? offset_words(residents_[i]) : pool_.capacity_words();
  };
  const auto end_of = [&](std::size_t i) {
    return offset_words(residents_[i]) + aligned_words(page_words(residents_[i]));
  };
  // Pages first..last slide; the hole before `first` and those behind each of them join.
  std::size_t best_first = 0;
  std::size_t best_last = 0;
  std::uint64_t best_moved = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t holes = 0;
  std::uint64_t moved = 0;
  for (std::size_t first = 0, next = 0; first < residents_.size(); ++first) {
    const std::uint64_t before = begin_of(first) - (first == 0 ? 0 : end_of(first - 1));
    for (; next < residents_.size() && before + holes < words; ++next) {
      holes += begin_of(next + 1) - end_of(next);
      moved += end_of(next) - begin_of(next);
    }
    if (before + holes < words) break;
    if (moved < best_moved) {
      best_moved = moved;
      best_first = first;
      best_last = next;
    }
    holes -= begin_of(first + 1) - end_of(first);
    moved -= end_of(first) - begin_of(first);
  }
  ZC_CHECK(best_moved != std::numeric_limits<std::uint64_t>::max());  // all holes together are large enough
  std::uint64_t to = best_first == 0 ? 0 : end_of(best_first - 1);
  for (std::size_t i = best_first; i < best_last; ++i) {
    const std::uint32_t node = residents_[i];
    const std::uint64_t from = offset_words(node);
    const std::uint64_t count = page_words(node);
    if (from != to) {
      ZC_TRY(sink_.move(from, to, count));
      pool_.free(from, count);
      pool_.take(to, count);
      offsets_[node] = static_cast<std::uint32_t>(to / kPageAlignWords);
      compacted_bytes_ += 4 * count;
    }
    to += aligned_words(count);
  }
  ++compactions_;
  changed_ = true;
  return {};
}

void PagePool::update_rendered_cut() {
  if (!std::exchange(changed_, false)) return;
  std::swap(cut_, previous_cut_);
  nodes_.collect(cut_);
  bool changed = cut_ != previous_cut_;
  cut_offsets_.resize(cut_.size());
  for (std::size_t i = 0; i < cut_.size(); ++i)
    if (const std::uint64_t offset = offset_words(cut_[i]); std::exchange(cut_offsets_[i], offset) != offset)
      changed = true;
  if (changed) ++generation_;
}

}  // namespace zc
