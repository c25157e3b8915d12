// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/compute_kernel.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

#include "base/check.h"

namespace zc {

Result<std::unique_ptr<ComputeKernel>> ComputeKernel::create(Device& device, const KernelOptions& options) {
  std::unique_ptr<ComputeKernel> kernel(new ComputeKernel(device));
  kernel->buffers_ = options.buffers;
  ZC_TRY(kernel->create_layout(options));
  ZC_TRY(kernel->create_pipeline(options));
  if (device.has_timestamps()) {
    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = 2;
    ZC_VK(vkCreateQueryPool(device.handle(), &queries, nullptr, &kernel->queries_));
  }
  return kernel;
}

ComputeKernel::~ComputeKernel() {
  const VkDevice device = device_.handle();
  vkDestroyQueryPool(device, queries_, nullptr);
  vkDestroyPipeline(device, pipeline_, nullptr);
  vkDestroyShaderModule(device, module_, nullptr);
  vkDestroyDescriptorPool(device, pool_, nullptr);
  vkDestroyPipelineLayout(device, pipeline_layout_, nullptr);
  vkDestroyDescriptorSetLayout(device, set_layout_, nullptr);
}

Status ComputeKernel::create_layout(const KernelOptions& options) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (std::uint32_t i = 0; i < options.buffers; ++i)
    bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  std::vector<VkDescriptorPoolSize> sizes = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, std::max(1U, options.buffers)}};
  if (options.acceleration_structure) {
    bindings.push_back(
        {options.buffers, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    sizes.push_back({VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1});
  }
  VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set.pBindings = bindings.data();
  ZC_VK(vkCreateDescriptorSetLayout(device_.handle(), &set, nullptr, &set_layout_));

  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, options.push_bytes};
  VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout_;
  layout.pushConstantRangeCount = options.push_bytes > 0 ? 1 : 0;
  layout.pPushConstantRanges = &push;
  ZC_VK(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &pipeline_layout_));

  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  ZC_VK(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_));
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout_;
  return vk_status(vkAllocateDescriptorSets(device_.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
}

Status ComputeKernel::create_pipeline(const KernelOptions& options) {
  VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module.codeSize = options.spirv.size_bytes();
  module.pCode = options.spirv.data();
  ZC_VK(vkCreateShaderModule(device_.handle(), &module, nullptr, &module_));

  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < options.constants.size(); ++i) entries.push_back({i, 4 * i, 4});
  const VkSpecializationInfo constants{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                       options.constants.size() * 4, options.constants.data()};
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfoEXT subgroup{
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO_EXT};
  subgroup.requiredSubgroupSize = options.required_subgroup_size;
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module_;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &constants;
  if (options.required_subgroup_size != 0) {
    if (options.required_subgroup_size < device_.min_subgroup_size() ||
        options.required_subgroup_size > device_.max_subgroup_size())
      return Error{ErrorCode::kDevice,
                   device_.name() + " has no subgroups of " + std::to_string(options.required_subgroup_size)};
    info.stage.pNext = &subgroup;
  }
  info.layout = pipeline_layout_;
  return vk_status(vkCreateComputePipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_),
                   "vkCreateComputePipelines");
}

Status ComputeKernel::bind(std::uint32_t binding, const Buffer& buffer) {
  ZC_CHECK(binding < buffers_);
  if (buffer.bytes() > device_.limits().maxStorageBufferRange)
    return Error{ErrorCode::kDevice, "a buffer of " + std::to_string(buffer.bytes()) + " bytes, where " +
                                         device_.name() + " reaches " +
                                         std::to_string(device_.limits().maxStorageBufferRange)};
  const VkDescriptorBufferInfo info{buffer.handle(), 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = &info;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
  return {};
}

void ComputeKernel::bind(VkAccelerationStructureKHR structure) {
  VkWriteDescriptorSetAccelerationStructureKHR structures{
      VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
  structures.accelerationStructureCount = 1;
  structures.pAccelerationStructures = &structure;
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.pNext = &structures;
  write.dstSet = set_;
  write.dstBinding = buffers_;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

Result<KernelTimes> ComputeKernel::run(std::span<const std::byte> push, std::uint32_t groups_x, std::uint32_t groups_y,
                                       std::uint32_t repetitions) {
  ZC_CHECK(repetitions > 0);
  std::vector<double> times;
  for (std::uint32_t i = 0; i < repetitions; ++i) {
    ZC_ASSIGN(const double ms, run_once(push, groups_x, groups_y));
    times.push_back(ms);
  }
  std::ranges::sort(times);
  const std::size_t half = times.size() / 2;
  return KernelTimes{times.front(), times.size() % 2 == 1 ? times[half] : (times[half - 1] + times[half]) / 2};
}

Result<double> ComputeKernel::run_once(std::span<const std::byte> push, std::uint32_t groups_x,
                                       std::uint32_t groups_y) {
  const auto start = std::chrono::steady_clock::now();
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    // The submission itself makes the CPU's writes visible; copies and builds before it are made so here.
    VkMemoryBarrier before{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    before.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    before.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &before, 0,
                         nullptr, 0, nullptr);
    if (queries_ != VK_NULL_HANDLE) {
      vkCmdResetQueryPool(c, queries_, 0, 2);
      vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, 0);
    }
    vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_layout_, 0, 1, &set_, 0, nullptr);
    if (!push.empty())
      vkCmdPushConstants(c, pipeline_layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, static_cast<std::uint32_t>(push.size()),
                         push.data());
    vkCmdDispatch(c, groups_x, groups_y, 1);
    if (queries_ != VK_NULL_HANDLE) vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, 1);
    VkMemoryBarrier after{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    after.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    after.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &after, 0, nullptr, 0,
                         nullptr);
  }));
  if (queries_ == VK_NULL_HANDLE)
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  std::array<std::uint64_t, 2> ticks{};
  ZC_VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, 2, sizeof(ticks), ticks.data(), 8,
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  return device_.elapsed_ms(ticks[0], ticks[1]);
}

}  // namespace zc
