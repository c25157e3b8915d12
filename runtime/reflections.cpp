// SPDX-License-Identifier: Apache-2.0
#include "runtime/reflections.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "runtime/device/commands.h"
#include "runtime/frame_data.h"
#include "runtime/passes/pass_list.h"

namespace zc {
namespace {

constexpr VkBufferUsageFlags kStorage =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

}  // namespace

Result<std::unique_ptr<Reflections>> Reflections::create(Device& device, const ZoneSet& zones,
                                                         std::span<const gpu::MaterialEntry> materials,
                                                         const ReflectionsOptions& options) {
  std::unique_ptr<Reflections> made(new Reflections(device, zones));
  made->options_ = options;
  ZC_TRY(made->create_buffers(materials));
  ZC_TRY(made->schedule());
  return made;
}

Reflections::~Reflections() {
  for (const Slot& slot : slots_) vkDestroyQueryPool(device_.handle(), slot.queries, nullptr);
  vkDestroySampler(device_.handle(), sampler_, nullptr);
}

Features Reflections::features() const {
  return {options_.general || smoothest_ < options_.roughness_cut, options_.screen,
          options_.thread_per_pixel.value_or(!device_.is_cpu())};
}

Status Reflections::create_buffers(std::span<const gpu::MaterialEntry> materials) {
  ZC_CHECK(options_.width > 0 && options_.height > 0);
  ZC_CHECK(options_.frames_in_flight > 0 && options_.frames_in_flight <= kMaxFramesInFlight);
  const VkDeviceSize pixels = VkDeviceSize{options_.width} * options_.height;
  const VkDeviceSize largest = pixels * sizeof(gpu::RayTask);
  const VkPhysicalDeviceLimits& limits = device_.limits();
  if (largest > limits.maxStorageBufferRange || largest / 16 > limits.maxTexelBufferElements)
    return Error{ErrorCode::kDevice, "a picture of " + std::to_string(options_.width) + "x" +
                                         std::to_string(options_.height) + " takes a ray queue of " +
                                         std::to_string(largest) + " bytes, more than " + device_.name() + " binds (" +
                                         std::to_string(limits.maxStorageBufferRange) + ")"};
  for (const gpu::MaterialEntry& material : materials) smoothest_ = std::min(smoothest_, material.roughness);
  ZC_ASSIGN(materials_,
            Buffer::create(device_, std::max<VkDeviceSize>(1, materials.size()) * sizeof(gpu::MaterialEntry), kStorage,
                           MemoryUse::kUpload));
  std::ranges::copy(std::as_bytes(materials), materials_.mapped().begin());

  VkDeviceSize hiz_floats = 0;
  std::uint32_t width = options_.width;
  std::uint32_t height = options_.height;
  std::uint32_t level = 0;
  for (; level < gpu::kHizLevels; ++level) {
    frame_.hiz_levels[level] = {static_cast<std::uint32_t>(hiz_floats), width, height, 0};
    hiz_floats += VkDeviceSize{width} * height;
    if (width == 1 && height == 1) break;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
  frame_.hiz_level_count = std::min(level + 1, gpu::kHizLevels);
  ZC_ASSIGN(hiz_, Buffer::create(device_, hiz_floats * 4, kStorage, MemoryUse::kDevice));
  ZC_ASSIGN(provenance_, Buffer::create(device_, pixels * 4, kStorage, MemoryUse::kDevice));
  ZC_ASSIGN(pixels_, Buffer::create(device_, pixels * 4, kStorage, MemoryUse::kDevice));
  TraceQueueOptions queue;
  queue.max_rays = static_cast<std::uint32_t>(pixels);
  queue.limits =
      trace_limits(device_, options_.page_depth, zones_.top_depth_bound(), zones_.all_as_texels(), options_.step_limit);
  queue.variant = options_.trace;
  queue.check_access = options_.check_access;
  ZC_TRY(queue_.create(queue));

  const VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  ZC_VK(vkCreateSampler(device_.handle(), &sampler, nullptr, &sampler_));
  slots_.resize(options_.frames_in_flight);
  for (Slot& slot : slots_) {
    ZC_ASSIGN(slot.frame,
              Buffer::create(device_, sizeof(gpu::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::kUpload));
    ZC_ASSIGN(slot.counters,
              Buffer::create(device_, sizeof(gpu::Counters), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::kReadback));
    BindingTable& table = slot.table;
    table.set_buffer(gpu::kBindFrame, slot.frame.handle());
    table.set_buffer(gpu::kBindMaterials, materials_.handle());
    table.set_buffer(gpu::kBindHiz, hiz_.handle());
    table.set_buffer(gpu::kBindProvenance, provenance_.handle());
    table.set_buffer(gpu::kBindPixels, pixels_.handle());
    queue_.bind_to(table);
    bind_zones(zones_, table);
    if (!device_.has_timestamps()) continue;
    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = static_cast<std::uint32_t>(all_passes().size()) + 1;
    ZC_VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &slot.queries));
  }
  return {};
}

Status Reflections::schedule() {
  const Features now = features();
  ZC_TRY(queue_.prepare(false));
  Constants constants = queue_.constants();
  constants[kConstantStackShared] = 0;  // it is measured for the trace alone
  constants[kConstantUseScreen] = now.screen ? 1 : 0;
  constants[kConstantThreadPerPixel] = now.thread_per_pixel ? 1 : 0;
  scheduled_.clear();
  for (const ListedPass& listed : all_passes()) {
    if (listed.pass->left_out(now) != nullptr) continue;
    const auto adapted = std::ranges::find(options_.adapted_shaders, listed.name, &AdaptedShader::pass);
    const bool is_adapted = adapted != options_.adapted_shaders.end();
    ZC_ASSIGN(Program * program,
              programs_.compute(listed.name, is_adapted ? adapted->spirv : listed.spirv(), constants));
    scheduled_.push_back({listed.pass, program});
  }
  return {};
}

Status Reflections::reconfigure(const ReflectionsOptions& options) {
  const ReflectionsOptions before = std::exchange(options_, options);
  // Buffers belong to the size, the depth and the slots; all else is specialisation and what frames are told.
  const bool same_buffers =
      before.width == options.width && before.height == options.height && before.page_depth == options.page_depth &&
      before.frames_in_flight == options.frames_in_flight && before.check_access == options.check_access;
  ZC_CHECK(same_buffers);
  if (!(before.trace == options.trace)) ZC_TRY(queue_.set_variant(options.trace, false));
  return schedule();
}

void Reflections::write_frame(const HostFrame& frame, Slot& slot) {
  fill_frame_data(frame.camera, frame.sun, options_.width, options_.height, frame_);
  fill_frame_data(zones_, frame_);
  frame_.roughness_cut = options_.roughness_cut;
  frame_.screen_step_limit = options_.screen_steps;
  std::memcpy(slot.frame.mapped().data(), &frame_, sizeof(frame_));
  constexpr VkImageLayout read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  slot.table.set_image(gpu::kBindDepth, frame.depth, read, sampler_);
  slot.table.set_image(gpu::kBindSurface, frame.surface, read, sampler_);
  slot.table.set_image(gpu::kBindIrradiance, frame.irradiance, read, sampler_);
}

Status Reflections::record(VkCommandBuffer commands, const HostFrame& frame, VkImageView out) {
  if (frame.depth == VK_NULL_HANDLE || frame.surface == VK_NULL_HANDLE || frame.irradiance == VK_NULL_HANDLE ||
      out == VK_NULL_HANDLE)
    return Error{ErrorCode::kArgument, "a frame needs images of depth, surface and irradiance, and one to write"};
  slot_ = (slot_ + 1) % static_cast<std::uint32_t>(slots_.size());
  Slot& slot = slots_[slot_];
  write_frame(frame, slot);
  slot.table.set_image(gpu::kBindReflection, out, VK_IMAGE_LAYOUT_GENERAL);

  const bool timed = options_.statistics && slot.queries != VK_NULL_HANDLE;
  std::uint32_t stamps = 0;
  const auto stamp = [&] {
    if (timed) vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, slot.queries, stamps++);
  };
  if (timed) vkCmdResetQueryPool(commands, slot.queries, 0, static_cast<std::uint32_t>(all_passes().size()) + 1);
  // The scratch is the frame before's too.
  memory_barrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                 VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                 VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  vkCmdFillBuffer(commands, queue_.counters().handle(), 0, VK_WHOLE_SIZE, 0);
  barrier_after_transfer(commands);
  stamp();
  const Features now = features();
  for (const Scheduled& scheduled : scheduled_) {
    PassRecorder recorder(commands, *scheduled.program, slot.table, slot_, queue_, frame_, now);
    scheduled.pass->record(recorder);
    stamp();
  }
  if (!options_.statistics) return {};
  const VkBufferCopy counters{0, 0, sizeof(gpu::Counters)};
  vkCmdCopyBuffer(commands, queue_.counters().handle(), slot.counters.handle(), 1, &counters);
  barrier_after_transfer(commands);
  return {};
}

Result<FrameReport> Reflections::report() const {
  ZC_CHECK(options_.statistics);
  const Slot& slot = slots_[slot_];
  FrameReport report;
  std::memcpy(&report.counters, slot.counters.mapped().data(), sizeof(report.counters));
  std::vector<std::uint64_t> ticks(scheduled_.size() + 1);
  if (slot.queries != VK_NULL_HANDLE)
    ZC_VK(vkGetQueryPoolResults(device_.handle(), slot.queries, 0, static_cast<std::uint32_t>(ticks.size()),
                                ticks.size() * sizeof(ticks[0]), ticks.data(), sizeof(ticks[0]),
                                VK_QUERY_RESULT_64_BIT));
  for (std::size_t i = 0; i < scheduled_.size(); ++i)
    report.passes.push_back({scheduled_[i].pass->key, device_.elapsed_ms(ticks[i], ticks[i + 1])});
  return report;
}

std::vector<LeftOutPass> Reflections::left_out() const {
  std::vector<LeftOutPass> out;
  for (const ListedPass& listed : all_passes()) {
    const char* reason = listed.pass->left_out(features());
    if (reason == nullptr) continue;
    const auto known = std::ranges::find(out, reason, &LeftOutPass::reason);
    if (known == out.end())
      out.push_back({listed.pass->key, reason});
    else
      known->passes += std::string(", ") + listed.pass->key;
  }
  return out;
}

std::uint64_t Reflections::scratch_bytes() const {
  std::uint64_t bytes = materials_.bytes() + hiz_.bytes() + provenance_.bytes() + pixels_.bytes() + queue_.bytes();
  for (const Slot& slot : slots_) bytes += slot.frame.bytes() + slot.counters.bytes();
  return bytes;
}

Result<bool> Reflections::choose_trace_variant(std::uint32_t ray_count, double budget_ms) {
  ZC_ASSIGN(const bool complete, queue_.choose_variant(ray_count, slots_[slot_].table, slot_, budget_ms));
  options_.trace = queue_.variant();
  ZC_TRY(schedule());  // what else reads pages reads them the same way
  return complete;
}

}  // namespace zc
