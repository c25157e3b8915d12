// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/zone_set.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/check.h"

namespace zc {
namespace {

constexpr VkDeviceSize kStagingBytes = VkDeviceSize{1} << 20;

void wait_for_transfer(VkCommandBuffer commands) {
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0,
                       nullptr, 0, nullptr);
}

void copy(VkCommandBuffer commands, const Buffer& from, VkDeviceSize from_bytes, const Buffer& to,
          VkDeviceSize to_bytes, VkDeviceSize bytes) {
  const VkBufferCopy region{from_bytes, to_bytes, bytes};
  vkCmdCopyBuffer(commands, from.handle(), to.handle(), 1, &region);
  wait_for_transfer(commands);
}

}  // namespace

Status ZoneSet::create(std::uint64_t capacity_words, std::uint32_t max_zones) {
  max_zones_ = max_zones;
  const VkPhysicalDeviceLimits& limits = device_.limits();
  const std::uint64_t pages_words =
      (capacity_words + gpu::kPageAlignWords - 1) / gpu::kPageAlignWords * gpu::kPageAlignWords;
  const std::uint64_t top_words = std::uint64_t{top_level_node_bound(max_zones)} * gpu::kPageNodeWords;
  const VkDeviceSize bytes = (pages_words + top_words) * 4;
  if (bytes / 4 > gpu::kPoolMaxWords)
    return Error{ErrorCode::kUnsupported,
                 "a page pool of " + std::to_string(bytes) + " bytes, more than hits can number"};
  if (bytes > limits.maxStorageBufferRange || bytes / 4 > limits.maxTexelBufferElements)
    return Error{ErrorCode::kDevice, "a page pool of " + std::to_string(bytes) + " bytes is more than " +
                                         device_.name() + " binds (storage " +
                                         std::to_string(limits.maxStorageBufferRange) + " bytes, texel buffers " +
                                         std::to_string(limits.maxTexelBufferElements) + " words)"};
  constexpr VkBufferUsageFlags usage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  const VkDeviceSize zones = std::max<std::uint32_t>(max_zones, 1);
  ZC_ASSIGN(pool_,
            Buffer::create(device_, bytes, usage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, MemoryUse::kDevice));
  ZC_ASSIGN(texels_, BufferView::create(device_, pool_, VK_FORMAT_R32_UINT));
  ZC_ASSIGN(texels4_, BufferView::create(device_, pool_, VK_FORMAT_R32G32B32A32_UINT));
  ZC_ASSIGN(zones_, Buffer::create(device_, zones * sizeof(gpu::ZoneEntry), usage, MemoryUse::kDevice));
  root_word_ = static_cast<std::uint32_t>(pages_words);
  if (use_staging_ || pool_.mapped().empty() || zones_.mapped().empty()) {
    use_staging_ = true;
    ZC_ASSIGN(staging_, Buffer::create(device_, kStagingBytes, usage, MemoryUse::kUpload));
  }
  return set_zones({});
}

Status ZoneSet::write(const Buffer& target, std::uint64_t offset_bytes, std::span<const std::byte> bytes) {
  ZC_CHECK(offset_bytes + bytes.size() <= target.bytes());
  if (bytes.empty()) return {};  // the first tables are, and memcpy takes no null pointer
  if (!use_staging_) {
    std::memcpy(target.mapped().data() + offset_bytes, bytes.data(), bytes.size());
    return {};
  }
  for (std::size_t done = 0; done < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - done, kStagingBytes);
    std::memcpy(staging_.mapped().data(), bytes.data() + done, part);
    ZC_TRY(device_.run([&](VkCommandBuffer c) { copy(c, staging_, 0, target, offset_bytes + done, part); }));
    done += part;
  }
  return {};
}

std::vector<ZoneSet::Resident>::iterator ZoneSet::first_from(std::uint64_t word) {
  return std::ranges::lower_bound(residents_, word, {}, &Resident::page_word);
}

Status ZoneSet::upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) {
  // Pages that this one overwrites are gone.
  const auto at = residents_.erase(first_from(offset_words), first_from(offset_words + page.size()));
  residents_.insert(at, {offset_words, std::make_unique<PageRoot>(page_root(page))});
  return write(pool_, offset_words * 4, std::as_bytes(page));
}

Status ZoneSet::move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) {
  const VkDeviceSize from = from_words * 4;
  const VkDeviceSize to = to_words * 4;
  const VkDeviceSize bytes = count_words * 4;
  ZC_CHECK(std::max(from, to) + bytes <= pool_.bytes());
  if (const auto moved = first_from(from_words); moved != residents_.end() && moved->page_word == from_words) {
    std::unique_ptr<PageRoot> root = std::move(moved->root);
    residents_.erase(moved);
    auto at = first_from(to_words);
    if (at == residents_.end() || at->page_word != to_words) at = residents_.insert(at, {to_words, nullptr});
    at->root = std::move(root);
  }
  if (!use_staging_) {
    std::memmove(pool_.mapped().data() + to, pool_.mapped().data() + from, bytes);
    return {};
  }
  // Copies within one buffer must not overlap: part by part through the staging buffer, from the side that is safe.
  return device_.run([&](VkCommandBuffer c) {
    for (VkDeviceSize done = 0; done < bytes;) {
      const VkDeviceSize part = std::min(bytes - done, kStagingBytes);
      const VkDeviceSize at = to < from ? done : bytes - done - part;
      copy(c, pool_, from + at, staging_, 0, part);
      copy(c, staging_, 0, pool_, to + at, part);
      done += part;
    }
  });
}

Status ZoneSet::set_zones(std::span<const gpu::ZoneEntry> zones) {
  ZC_CHECK(zones.size_bytes() <= zones_.bytes());
  traced_.clear();
  triangle_counts_.clear();
  auto resident = residents_.begin();
  for (const gpu::ZoneEntry& zone : zones) {
    ZC_CHECK(traced_.empty() || traced_.back().page_word < zone.page_word);
    while (resident != residents_.end() && resident->page_word < zone.page_word) ++resident;
    ZC_CHECK(resident != residents_.end() && resident->page_word == zone.page_word);
    traced_.push_back({zone.page_word, resident->root.get()});
    triangle_counts_.push_back(resident->root->triangle_count);
  }
  top_.build(traced_, root_word_);
  zone_count_ = static_cast<std::uint32_t>(zones.size());
  end_word_ = root_word_ + static_cast<std::uint32_t>(top_.nodes().size()) * gpu::kPageNodeWords;
  ZC_TRY(write(zones_, 0, std::as_bytes(zones)));
  return write(pool_, std::uint64_t{root_word_} * 4, std::as_bytes(top_.nodes()));
}

}  // namespace zc
