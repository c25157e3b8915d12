// SPDX-License-Identifier: Apache-2.0
#include "runtime/tracing/trace_queue.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

#include "base/check.h"
#include "runtime/device/commands.h"
#include "shaders/shared/frame.h"
#include "spirv/passes.h"

namespace zc {
namespace {

constexpr std::uint32_t kRun = 64;  // rays that stay together when the queue is thinned out: a packet
// Of choose_variant.
constexpr double kRoundMs = 5;
constexpr int kRounds = 5;
constexpr std::uint32_t kMostRays = 1U << 20U;  // keep any device busy

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

TraceLimits trace_limits(const Device& device, std::uint32_t page_depth, std::uint32_t top_level_depth,
                         bool pool_as_texels, std::uint32_t step_limit) {
  // A level leaves at most one entry behind, and the last none.
  return {device.subgroup_size(), device.limits().maxComputeSharedMemorySize, page_depth + top_level_depth,
          pool_as_texels, step_limit > 0 ? step_limit : zc::step_limit(device.name())};
}

TraceQueue::~TraceQueue() { vkDestroyQueryPool(device_.handle(), queries_, nullptr); }

Status TraceQueue::create(const TraceQueueOptions& options) {
  options_ = options;
  options_.variant = nearest_fit(options.variant, options.limits);
  const VkDeviceSize rays = std::max(1U, options.max_rays);
  constexpr VkBufferUsageFlags storage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  ZC_ASSIGN(rays_, Buffer::create(device_, rays * sizeof(gpu::RayTask),
                                  storage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, MemoryUse::kDevice));
  ZC_ASSIGN(ray_texels_, BufferView::create(device_, rays_, VK_FORMAT_R32G32B32A32_UINT));
  ZC_ASSIGN(hits_, Buffer::create(device_, rays * sizeof(gpu::HitRecord), storage, MemoryUse::kDevice));
  ZC_ASSIGN(fallback_rays_,
            Buffer::create(device_, (rays / 8 + 1) * sizeof(gpu::FallbackRays), storage, MemoryUse::kDevice));
  ZC_ASSIGN(counters_, Buffer::create(device_, sizeof(gpu::Counters), storage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                                      MemoryUse::kDevice));
  ZC_ASSIGN(counters_upload_,
            Buffer::create(device_, sizeof(gpu::Counters), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::kUpload));
  if (!device_.has_timestamps()) return {};
  VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = 2;
  return vk_status(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_), "vkCreateQueryPool");
}

std::uint64_t TraceQueue::bytes() const {
  return rays_.bytes() + hits_.bytes() + fallback_rays_.bytes() + counters_.bytes() + counters_upload_.bytes();
}

void TraceQueue::bind_to(BindingTable& table) const {
  table.set_buffer(gpu::kBindRays, rays_.handle());
  table.set_texels(gpu::kBindRayTexels4, ray_texels_.handle());
  table.set_buffer(gpu::kBindHits, hits_.handle());
  table.set_buffer(gpu::kBindFallbackRays, fallback_rays_.handle());
  table.set_buffer(gpu::kBindCounters, counters_.handle());
}

Constants TraceQueue::constants_of(const TraceVariant& variant, bool any_hit) const {
  Constants constants{};
  constants[kConstantStackSize] = options_.limits.stack_entries;
  constants[kConstantPoolPath] = variant.pool_path;
  constants[kConstantRaysPerLane] = variant.rays_per_lane;
  constants[kConstantCheckAccess] = options_.check_access ? 1 : 0;
  constants[kConstantStackShared] = variant.stack_shared ? 1 : 0;
  constants[kConstantTraceWidth] = variant.width;
  constants[kConstantAnyHit] = any_hit ? 1 : 0;
  constants[kConstantStepLimit] = options_.limits.steps;
  return constants;
}

Result<TraceQueue::Kernels> TraceQueue::make_kernels(const TraceVariant& variant, bool any_hit) const {
  const Constants constants = constants_of(variant, any_hit);
  const bool pages = options_.kernels.rays.empty();
  Kernels kernels;
  ZC_ASSIGN(kernels.size, programs_.compute("size_dispatch", shader::size_dispatch(), constants));
  ZC_ASSIGN(kernels.rays,
            programs_.compute("trace_rays", pages ? shader::trace_rays() : options_.kernels.rays, constants));
  if (variant.rays_per_lane > 0) {
    ZC_ASSIGN(
        kernels.packets,
        programs_.compute("trace_packets", pages ? shader::trace_packets() : options_.kernels.packets, constants));
  }
  return kernels;
}

Status TraceQueue::prepare(bool any_hit) {
  ZC_ASSIGN(kernels_, make_kernels(options_.variant, any_hit));
  return {};
}

Status TraceQueue::set_variant(const TraceVariant& variant, bool any_hit) {
  options_.variant = nearest_fit(variant, options_.limits);
  return prepare(any_hit);
}

void TraceQueue::record_sizes(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot) const {
  kernels_.size->bind(commands, table, slot);
  vkCmdDispatch(commands, 1, 1, 1);
  barrier_after_compute(commands);
}

void TraceQueue::record_trace(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot) const {
  if (kernels_.packets != nullptr) {
    kernels_.packets->bind(commands, table, slot);
    vkCmdDispatchIndirect(commands, counters_.handle(), offsetof(gpu::Counters, packet_groups_x));
    barrier_after_compute(commands);
    record_sizes(commands, table, slot);
  }
  kernels_.rays->bind(commands, table, slot);
  vkCmdDispatchIndirect(commands, counters_.handle(), offsetof(gpu::Counters, fallback_groups_x));
  barrier_after_compute(commands);
}

Result<double> TraceQueue::trace_now(std::uint32_t ray_count, const BindingTable& table, std::uint32_t slot) {
  gpu::Counters counters{};
  counters.ray_count = ray_count;
  std::memcpy(counters_upload_.mapped().data(), &counters, sizeof(counters));
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    const VkBufferCopy block{0, 0, sizeof(counters)};
    vkCmdCopyBuffer(c, counters_upload_.handle(), counters_.handle(), 1, &block);
    barrier_after_transfer(c);
    record_sizes(c, table, slot);
  }));
  const auto start = Clock::now();
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    const auto stamp = [&](std::uint32_t i) {
      if (queries_ != VK_NULL_HANDLE) vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, i);
    };
    if (queries_ != VK_NULL_HANDLE) vkCmdResetQueryPool(c, queries_, 0, 2);
    stamp(0);
    record_trace(c, table, slot);
    stamp(1);
  }));
  if (queries_ == VK_NULL_HANDLE) return ms_since(start);
  std::array<std::uint64_t, 2> ticks{};
  ZC_VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, 2, sizeof(ticks), ticks.data(), sizeof(ticks[0]),
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  return device_.elapsed_ms(ticks[0], ticks[1]);
}

// Brings runs of rays from all over the queue to its front.
Status TraceQueue::thin_out(std::uint32_t ray_count, std::uint32_t runs) {
  const VkDeviceSize bytes = VkDeviceSize{runs} * kRun * sizeof(gpu::RayTask);
  ZC_ASSIGN(thinned_,
            Buffer::create(device_, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                           MemoryUse::kDevice));
  std::vector<VkBufferCopy> out;
  for (std::uint32_t run = 0; run < runs; ++run) {
    const VkDeviceSize from = VkDeviceSize{run} * (ray_count / kRun) / runs;
    out.push_back({from * kRun * sizeof(gpu::RayTask), VkDeviceSize{run} * kRun * sizeof(gpu::RayTask),
                   kRun * sizeof(gpu::RayTask)});
  }
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    vkCmdCopyBuffer(c, rays_.handle(), thinned_.handle(), runs, out.data());
    barrier_after_transfer(c);
    const VkBufferCopy back{0, 0, bytes};
    vkCmdCopyBuffer(c, thinned_.handle(), rays_.handle(), 1, &back);
    barrier_after_transfer(c);
  }));
  thinned_ = {};
  return {};
}

Result<bool> TraceQueue::choose_variant(std::uint32_t ray_count, const BindingTable& table, std::uint32_t slot,
                                        double budget_ms) {
  ZC_CHECK(ray_count >= kRaysToChoose);
  // Of slow devices only as many rays as the kernels in use trace in kRoundMs.
  ZC_TRY(prepare(false));
  ZC_ASSIGN(const double whole_ms, trace_now(ray_count, table, slot));
  const double in_round = ray_count * kRoundMs / std::max(whole_ms, 1e-6);
  const auto rays =
      static_cast<std::uint32_t>(std::clamp<double>(in_round, kRaysToChoose, std::min(ray_count, kMostRays)));
  if (rays < ray_count) ZC_TRY(thin_out(ray_count, rays / kRun));
  const auto start = Clock::now();
  bool complete = true;

  const auto measure = [&](std::span<const TraceVariant> variants) -> Result<std::vector<double>> {
    std::vector<double> best_ms;
    if (ms_since(start) > budget_ms) {
      complete = false;
      return best_ms;
    }
    for (const TraceVariant& variant : variants) {
      ZC_ASSIGN(kernels_, make_kernels(variant, false));
      ZC_TRY(trace_now(kRun, table, slot));  // some drivers compile only now
    }
    // In turn, so that whatever else the machine does hits all alike; it only ever adds.
    best_ms.assign(variants.size(), INFINITY);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 0; i < variants.size(); ++i) {
        ZC_ASSIGN(kernels_, make_kernels(variants[i], false));
        ZC_ASSIGN(const double ms, trace_now(rays, table, slot));
        best_ms[i] = std::min(best_ms[i], ms);
      }
    }
    return best_ms;
  };
  ZC_ASSIGN(const TraceVariant chosen, choose_trace_variant(options_.limits, measure));
  ZC_TRY(set_variant(chosen, false));
  return complete;
}

}  // namespace zc
