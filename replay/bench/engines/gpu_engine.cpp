// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/gpu_engine.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/check.h"
#include "replay/bench/engines/stopwatch.h"

namespace zc::bench {
namespace {

constexpr std::uint32_t kGroupRays = 64;
constexpr std::uint32_t kGroupsInRow = 32768;  // below the 65,535 that every device takes

Status copy(Device& device, const Buffer& from, const Buffer& to, VkDeviceSize bytes) {
  return device.run([&](VkCommandBuffer c) {
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(c, from.handle(), to.handle(), 1, &region);
    VkMemoryBarrier after{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    after.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    after.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &after, 0, nullptr, 0,
                         nullptr);
  });
}

}  // namespace

Result<Buffer> make_filled_buffer(Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags more_usage) {
  constexpr VkBufferUsageFlags usage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  ZC_ASSIGN(Buffer buffer,
            Buffer::create(device, std::max<VkDeviceSize>(bytes.size(), 4), usage | more_usage, MemoryUse::kDevice));
  ZC_TRY(write_buffer(device, buffer, bytes));
  return buffer;
}

Status write_buffer(Device& device, const Buffer& buffer, std::span<const std::byte> bytes) {
  ZC_CHECK(bytes.size() <= buffer.bytes());
  if (bytes.empty()) return {};
  if (!buffer.mapped().empty()) {
    std::memcpy(buffer.mapped().data(), bytes.data(), bytes.size());
    return {};
  }
  ZC_ASSIGN(const Buffer staging,
            Buffer::create(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::kUpload));
  std::memcpy(staging.mapped().data(), bytes.data(), bytes.size());
  return copy(device, staging, buffer, bytes.size());
}

Status read_buffer(Device& device, const Buffer& buffer, std::span<std::byte> bytes) {
  ZC_CHECK(bytes.size() <= buffer.bytes());
  if (bytes.empty()) return {};
  if (!buffer.mapped().empty()) {
    std::memcpy(bytes.data(), buffer.mapped().data(), bytes.size());
    return {};
  }
  ZC_ASSIGN(const Buffer staging,
            Buffer::create(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::kReadback));
  ZC_TRY(copy(device, buffer, staging, bytes.size()));
  std::memcpy(bytes.data(), staging.mapped().data(), bytes.size());
  return {};
}

Result<double> copy_gb_per_s(Device& device) {
  constexpr VkDeviceSize bytes = VkDeviceSize{128} << 20;  // more than any cache holds
  constexpr unsigned few = 2;
  constexpr unsigned many = 10;
  constexpr VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  ZC_ASSIGN(const Buffer from, Buffer::create(device, bytes, usage, MemoryUse::kDevice));
  ZC_ASSIGN(const Buffer to, Buffer::create(device, bytes, usage, MemoryUse::kDevice));
  const auto best_ms = [&](unsigned copies) -> Result<double> {
    double best = std::numeric_limits<double>::infinity();
    for (unsigned run = 0; run < 4; ++run) {
      const Stopwatch watch;
      ZC_TRY(device.run([&](VkCommandBuffer c) {
        const VkBufferCopy region{0, 0, bytes};
        VkMemoryBarrier between{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        between.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        between.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        for (unsigned i = 0; i < copies; ++i) {
          vkCmdCopyBuffer(c, from.handle(), to.handle(), 1, &region);
          vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &between, 0,
                               nullptr, 0, nullptr);
        }
      }));
      best = std::min(best, watch.ms());
    }
    return best;
  };
  // The difference leaves out what a submission costs.
  ZC_ASSIGN(const double few_ms, best_ms(few));
  ZC_ASSIGN(const double many_ms, best_ms(many));
  return many_ms > few_ms ? 2e-6 * static_cast<double>(bytes) * (many - few) / (many_ms - few_ms) : 0;
}

Status GpuEngine::set_kernel(KernelOptions options, std::vector<Buffer> data, std::vector<std::uint32_t> push) {
  data_ = std::move(data);
  push_ = std::move(push);
  push_.insert(push_.begin(), 0);
  options.constants.insert(options.constants.begin(), any_hit_ ? 1 : 0);
  options.buffers = static_cast<std::uint32_t>(2 + data_.size());
  options.push_bytes = static_cast<std::uint32_t>(4 * push_.size());
  ZC_ASSIGN(kernel_, ComputeKernel::create(device_, options));
  for (std::uint32_t i = 0; i < data_.size(); ++i) ZC_TRY(kernel_->bind(2 + i, data_[i]));
  return {};
}

Result<double> GpuEngine::trace(std::span<const BenchRay> rays, std::span<BenchHit> hits) {
  ZC_CHECK(kernel_ != nullptr && rays.size() == hits.size());
  if (rays_.bytes() < rays.size_bytes() || hits_.bytes() < hits.size_bytes()) {
    ZC_ASSIGN(rays_, make_filled_buffer(device_, std::as_bytes(rays)));
    ZC_ASSIGN(hits_, make_filled_buffer(device_, std::as_bytes(hits)));
    ZC_TRY(kernel_->bind(0, rays_));
    ZC_TRY(kernel_->bind(1, hits_));
  }
  ZC_TRY(write_buffer(device_, rays_, std::as_bytes(rays)));
  ZC_TRY(write_buffer(device_, hits_, std::as_bytes(hits)));
  push_[0] = static_cast<std::uint32_t>(rays.size());
  const std::uint32_t groups = (push_[0] + kGroupRays - 1) / kGroupRays;
  const std::uint32_t columns = std::min(groups, kGroupsInRow);
  ZC_ASSIGN(const KernelTimes times,
            kernel_->run(std::as_bytes(std::span(push_)), columns, (groups + columns - 1) / columns));
  ZC_TRY(read_buffer(device_, hits_, std::as_writable_bytes(hits)));
  return times.min_ms;
}

}  // namespace zc::bench
