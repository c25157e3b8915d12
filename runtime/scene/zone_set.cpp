// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/zone_set.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/check.h"

namespace zc {
namespace {

// What drivers round the three buffers up by, and allocators the lists, ours and the top-level builder's: blocks of
// 128 KiB and more to whole pages of 4 KiB, smaller ones to a few words.
constexpr std::uint64_t kRoundingBytes = 3 * 1024 + 17 * 32;
constexpr std::uint64_t rounded(std::uint64_t bytes) { return bytes + bytes / 32 + 1; }

constexpr std::uint64_t kNodeBytes = sizeof(gpu::PageNode);

constexpr VkBufferUsageFlags kPoolUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                          VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                          VK_BUFFER_USAGE_TRANSFER_SRC_BIT;

// Memory types are the same for all buffers of one usage.
bool maps_pools(const Device& device) {
  const Result<Buffer> probe = Buffer::create(device, 256, kPoolUsage, MemoryUse::kDevice);
  return probe && !probe->mapped().empty();
}

}  // namespace

ZoneSet::ZoneSet(Device& device, const ZoneSetOptions& options)
    : device_(device),
      options_(options),
      is_mapped_(options.frames_in_flight == 0 && !options.use_staging && maps_pools(device)),
      transfers_(device) {}

SinkCosts ZoneSet::costs() const {
  SinkCosts costs;
  costs.buffer_limit_bytes =
      std::min<std::uint64_t>(device_.limits().maxStorageBufferRange, 4 * std::uint64_t{gpu::kPoolMaxWords});
  costs.buffer_fixed_bytes = kTopLevelFixedNodes * kNodeBytes;
  costs.buffer_bytes_per_page = kTopLevelNodesPerPage * kNodeBytes;
  costs.fixed_bytes = costs.buffer_fixed_bytes + rounded(TopLevelBuilder::kFixedBytes) + kRoundingBytes;
  std::uint64_t lists = sizeof(Resident) + sizeof(PageRoot) + sizeof(std::uint32_t) + sizeof(gpu::ZoneEntry) +
                        sizeof(std::uint32_t) + sizeof(TracedPage) + TopLevelBuilder::kBytesPerPage;
  if (!is_mapped_) {
    costs.fixed_bytes += options_.staging_bytes + rounded(costs.buffer_fixed_bytes) + rounded(Transfers::heap_bytes());
    lists += sizeof(RootNodes) + costs.buffer_bytes_per_page;
  }
  costs.bytes_per_page = costs.buffer_bytes_per_page + sizeof(gpu::ZoneEntry) + rounded(lists);
  return costs;
}

Status ZoneSet::create(std::uint64_t capacity_words, std::uint64_t max_pages) {
  const std::uint64_t pages_words =
      (capacity_words + gpu::kPageAlignWords - 1) / gpu::kPageAlignWords * gpu::kPageAlignWords;
  const std::uint64_t limit_bytes = costs().buffer_limit_bytes;
  // Neither overflows below.
  const bool far_off = pages_words > limit_bytes / 4 || max_pages > limit_bytes / costs().buffer_bytes_per_page;
  max_pages_ = far_off ? 0 : static_cast<std::uint32_t>(max_pages);
  const std::uint64_t bytes = 4 * pages_words + kNodeBytes * top_level_node_bound(max_pages_);
  if (far_off || bytes > limit_bytes)
    return Error{ErrorCode::kDevice, "a pool of " + std::to_string(pages_words) + " words and " +
                                         std::to_string(max_pages) + " pages is more than " + device_.name() +
                                         " binds (" + std::to_string(limit_bytes) + " bytes)"};
  root_word_ = static_cast<std::uint32_t>(pages_words);
  ZC_TRY(create_buffers(bytes));
  residents_.reserve(max_pages_);
  roots_.resize(max_pages_);
  free_roots_.resize(max_pages_);
  for (std::uint32_t i = 0; i < max_pages_; ++i) free_roots_[i] = max_pages_ - 1 - i;
  entries_.reserve(max_pages_);
  triangle_counts_.reserve(max_pages_);
  traced_.reserve(max_pages_);
  const std::size_t nodes = top_level_node_bound(max_pages_);
  if (is_mapped_) {
    auto* behind_pages = reinterpret_cast<gpu::PageNode*>(pool_.mapped().data() + std::size_t{4} * root_word_);
    top_.reserve(max_pages_, {behind_pages, nodes});
  } else {
    root_nodes_.resize(max_pages_);
    top_nodes_.resize(nodes);
    top_.reserve(max_pages_, top_nodes_);
  }
  return show({});
}

Status ZoneSet::create_buffers(std::uint64_t pool_bytes) {
  ZC_ASSIGN(pool_, Buffer::create(device_, pool_bytes, kPoolUsage, MemoryUse::kDevice));
  // Of whole texels; a view of a part is bound, but not read, where the pool is larger.
  const std::uint64_t texels = std::min<std::uint64_t>(pool_bytes / 4, device_.limits().maxTexelBufferElements) / 4 * 4;
  all_as_texels_ = 4 * texels == pool_bytes;
  ZC_ASSIGN(texels_, BufferView::create(device_, pool_, VK_FORMAT_R32_UINT, 4 * texels));
  ZC_ASSIGN(texels4_, BufferView::create(device_, pool_, VK_FORMAT_R32G32B32A32_UINT, 4 * texels));
  const VkDeviceSize zones = std::max<std::uint32_t>(max_pages_, 1);
  ZC_ASSIGN(zones_, Buffer::create(device_, zones * sizeof(gpu::ZoneEntry), kPoolUsage, MemoryUse::kDevice));
  ZC_CHECK(!is_mapped_ || !(pool_.mapped().empty() || zones_.mapped().empty()));
  return is_mapped_ ? Status{} : transfers_.create(options_.staging_bytes, std::max(1U, options_.frames_in_flight));
}

Status ZoneSet::write(const Buffer& target, std::uint64_t offset_bytes, std::span<const std::byte> bytes) {
  ZC_CHECK(offset_bytes + bytes.size() <= target.bytes());
  if (!is_mapped_) return transfers_.write(target, offset_bytes, bytes);
  if (!bytes.empty()) std::memcpy(target.mapped().data() + offset_bytes, bytes.data(), bytes.size());
  return {};
}

// Ends a call of the sink: where the device is idle, now.
Status ZoneSet::settle() {
  if (is_mapped_ || options_.frames_in_flight > 0) return {};
  return transfers_.finish();
}

std::vector<ZoneSet::Resident>::iterator ZoneSet::first_from(std::uint64_t word) {
  return std::ranges::lower_bound(residents_, word, {}, &Resident::page_word);
}

Status ZoneSet::upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) {
  ZC_CHECK(offset_words + page.size() <= root_word_ && !free_roots_.empty());
  const auto next = first_from(offset_words);
  ZC_CHECK(next == residents_.end() || next->page_word >= offset_words + page.size());
  const std::uint32_t root = free_roots_.back();
  free_roots_.pop_back();
  roots_[root] = page_root(page);
  if (!is_mapped_) {
    const auto at = [&](std::size_t word) { return std::as_bytes(page).data() + 4 * word; };
    root_nodes_[root].nodes[0] = load_node(at(gpu::kPageHeaderWords));
    for (std::size_t c = 0; c < roots_[root].child_count; ++c)
      root_nodes_[root].nodes[1 + c] = load_node(at(roots_[root].child_words + c * gpu::kPageNodeWords));
  }
  residents_.insert(next, {static_cast<std::uint32_t>(offset_words), root});
  pages_changed_ = true;
  return write(pool_, offset_words * 4, std::as_bytes(page));
}

void ZoneSet::remove(std::uint64_t offset_words) {
  const auto resident = first_from(offset_words);
  ZC_CHECK(resident != residents_.end() && resident->page_word == offset_words);
  free_roots_.push_back(resident->root);
  residents_.erase(resident);
  pages_changed_ = true;
}

Status ZoneSet::move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) {
  const VkDeviceSize from = from_words * 4;
  const VkDeviceSize to = to_words * 4;
  const VkDeviceSize bytes = count_words * 4;
  ZC_CHECK(std::max(from, to) + bytes <= 4 * VkDeviceSize{root_word_});
  const auto resident = first_from(from_words);
  ZC_CHECK(resident != residents_.end() && resident->page_word == from_words);
  const std::uint32_t root = resident->root;
  residents_.erase(resident);
  residents_.insert(first_from(to_words), {static_cast<std::uint32_t>(to_words), root});
  pages_changed_ = true;
  if (!is_mapped_) return transfers_.move(pool_, from, to, bytes);
  std::memmove(pool_.mapped().data() + to, pool_.mapped().data() + from, bytes);
  return {};
}

Status ZoneSet::show(std::span<const ShownPage> pages) {
  ZC_CHECK(pages.size() <= max_pages_);
  bool same_pages = !pages_changed_ && pages.size() == entries_.size();
  entries_.resize(pages.size());
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const gpu::ZoneEntry entry{static_cast<std::uint32_t>(pages[i].offset_words), pages[i].node,
                               pages[i].coarse ? gpu::kZoneCoarse : 0};
    same_pages = same_pages && entries_[i].page_word == entry.page_word;
    entries_[i] = entry;
  }
  if (!same_pages) ZC_TRY(build_top_level());
  ZC_TRY(write(zones_, 0, std::as_bytes(std::span(entries_))));
  return settle();
}

// Over the pages of the zone table.
Status ZoneSet::build_top_level() {
  traced_.clear();
  triangle_counts_.clear();
  auto resident = residents_.begin();
  for (const gpu::ZoneEntry& zone : entries_) {
    ZC_CHECK(traced_.empty() || traced_.back().page_word < zone.page_word);
    while (resident != residents_.end() && resident->page_word < zone.page_word) ++resident;
    ZC_CHECK(resident != residents_.end() && resident->page_word == zone.page_word);
    const PageRoot& root = roots_[resident->root];
    if (is_mapped_) {
      traced_.push_back(traced_page(zone.page_word, root, pool_.mapped().data() + std::size_t{4} * zone.page_word));
    } else {
      const auto nodes = std::as_bytes(std::span(root_nodes_[resident->root].nodes));
      traced_.push_back({zone.page_word, &root, nodes.data(), nodes.data() + sizeof(gpu::PageNode)});
    }
    triangle_counts_.push_back(root.triangle_count);
  }
  top_.build(traced_, root_word_);
  pages_changed_ = false;
  end_word_ = root_word_ + static_cast<std::uint32_t>(top_.nodes().size()) * gpu::kPageNodeWords;
  if (is_mapped_) return {};  // it was built in its place
  return write(pool_, std::uint64_t{root_word_} * 4, std::as_bytes(top_.nodes()));
}

}  // namespace zc
