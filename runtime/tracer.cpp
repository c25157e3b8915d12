// SPDX-License-Identifier: Apache-2.0
#include "runtime/tracer.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "base/check.h"
#include "runtime/device/commands.h"
#include "runtime/frame_data.h"
#include "spirv/passes.h"

namespace zc {

Result<std::unique_ptr<Tracer>> Tracer::create(Device& device, const ZoneSet& zones, const TracerOptions& options) {
  std::unique_ptr<Tracer> tracer(new Tracer(device, zones));
  ZC_TRY(tracer->create(options));
  return tracer;
}

Status Tracer::create(const TracerOptions& options) {
  kernels_ = options.kernels;
  TraceQueueOptions queue;
  queue.max_rays = options.max_rays;
  queue.limits =
      trace_limits(device_, options.page_depth, zones_.top_depth_bound(), zones_.all_as_texels(), options.step_limit);
  queue.variant = options.trace;
  queue.check_access = options.check_access;
  queue.kernels = options.kernels;
  ZC_TRY(queue_.create(queue));
  ZC_ASSIGN(frame_,
            Buffer::create(device_, sizeof(gpu::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::kUpload));
  constexpr VkBufferUsageFlags copied = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const VkDeviceSize bytes =
      VkDeviceSize{options.max_rays} * std::max(sizeof(gpu::RayTask), sizeof(gpu::HitRecord)) + sizeof(gpu::Counters);
  ZC_ASSIGN(transfer_, Buffer::create(device_, bytes, copied, MemoryUse::kReadback));
  table_.set_buffer(gpu::kBindFrame, frame_.handle());
  queue_.bind_to(table_);
  bind_zones(zones_, table_);
  return {};
}

Result<std::vector<TracedHit>> Tracer::trace(const FrameCamera& camera, std::span<const gpu::RayTask> rays,
                                             bool any_hit, double* milliseconds) {
  ZC_CHECK(!rays.empty() && rays.size_bytes() <= queue_.rays().bytes());
  ZC_TRY(queue_.prepare(any_hit));
  ZC_ASSIGN(Program * resolve,
            programs_.compute("resolve_hits", kernels_.resolve.empty() ? shader::resolve_hits() : kernels_.resolve,
                              queue_.constants()));
  gpu::FrameData frame{};
  fill_frame_data(camera, {}, 1, 1, frame);
  fill_frame_data(zones_, frame);
  std::memcpy(frame_.mapped().data(), &frame, sizeof(frame));
  std::memcpy(transfer_.mapped().data(), rays.data(), rays.size_bytes());
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    const VkBufferCopy queue{0, 0, rays.size_bytes()};
    vkCmdCopyBuffer(c, transfer_.handle(), queue_.rays().handle(), 1, &queue);
    barrier_after_transfer(c);
  }));
  ZC_ASSIGN(const double ms, queue_.trace_now(static_cast<std::uint32_t>(rays.size()), table_, 0));
  const VkDeviceSize hit_bytes = rays.size() * sizeof(gpu::HitRecord);
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    resolve->bind(c, table_, 0);
    vkCmdDispatchIndirect(c, queue_.counters().handle(), offsetof(gpu::Counters, trace_groups_x));
    barrier_after_compute(c);
    const VkBufferCopy back{0, 0, hit_bytes};
    vkCmdCopyBuffer(c, queue_.hits().handle(), transfer_.handle(), 1, &back);
    const VkBufferCopy counted{0, hit_bytes, sizeof(gpu::Counters)};
    vkCmdCopyBuffer(c, queue_.counters().handle(), transfer_.handle(), 1, &counted);
    barrier_after_transfer(c);
  }));
  if (milliseconds != nullptr) *milliseconds = ms;
  std::memcpy(&counters_, transfer_.mapped().data() + hit_bytes, sizeof(counters_));
  std::vector<TracedHit> hits(rays.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    gpu::ResolvedHit hit;
    std::memcpy(&hit, transfer_.mapped().data() + i * sizeof hit, sizeof hit);
    hits[i] = {hit.t, hit.page_word, hit.triangle};
  }
  return hits;
}

Result<bool> Tracer::choose_trace_variant(std::uint32_t ray_count, double budget_ms) {
  return queue_.choose_variant(ray_count, table_, 0, budget_ms);
}

}  // namespace zc
