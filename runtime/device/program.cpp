// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/program.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/check.h"

namespace zc {
namespace {

constexpr auto kEntries = [] {
  std::array<VkSpecializationMapEntry, std::tuple_size_v<Constants>> entries{};
  for (std::uint32_t i = 0; i < entries.size(); ++i) entries[i] = {i, 4 * i, 4};
  return entries;
}();

VkSpecializationInfo specialization(const Constants& constants) {
  return {static_cast<std::uint32_t>(kEntries.size()), kEntries.data(), sizeof(constants), constants.data()};
}

}  // namespace

Result<std::unique_ptr<Program>> Program::create_compute(Device& device, const char* name,
                                                         std::span<const std::uint32_t> spirv,
                                                         const Constants& constants) {
  std::unique_ptr<Program> program(new Program(device));
  ZC_TRY(program->add_stage(name, spirv, VK_SHADER_STAGE_COMPUTE_BIT));
  ZC_TRY(program->check_limits(name));
  ZC_TRY(program->create_layout());
  const VkSpecializationInfo special = specialization(constants);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = program->stages(special).front();
  info.layout = program->layout_;
  ZC_VK(vkCreateComputePipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &program->pipeline_));
  program->destroy_modules();
  return program;
}

Result<std::unique_ptr<Program>> Program::create_graphics(Device& device, const char* name,
                                                          std::span<const std::uint32_t> vertex,
                                                          std::span<const std::uint32_t> fragment,
                                                          const GraphicsState& state, const Constants& constants) {
  std::unique_ptr<Program> program(new Program(device));
  program->point_ = VK_PIPELINE_BIND_POINT_GRAPHICS;
  ZC_TRY(program->add_stage(name, vertex, VK_SHADER_STAGE_VERTEX_BIT));
  ZC_TRY(program->add_stage(name, fragment, VK_SHADER_STAGE_FRAGMENT_BIT));
  ZC_TRY(program->check_limits(name));
  ZC_TRY(program->create_layout());

  const VkSpecializationInfo special = specialization(constants);
  const std::vector<VkPipelineShaderStageCreateInfo> stages = program->stages(special);
  const VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = state.topology;
  const VkViewport viewport{0, 0, static_cast<float>(state.width), static_cast<float>(state.height), 0, 1};
  const VkRect2D scissor{{0, 0}, {state.width, state.height}};
  VkPipelineViewportStateCreateInfo view{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  view.viewportCount = 1;
  view.pViewports = &viewport;
  view.scissorCount = 1;
  view.pScissors = &scissor;
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = VK_CULL_MODE_NONE;  // city models do not keep their winding
  raster.lineWidth = 1.0F;
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = state.depth_write ? VK_TRUE : VK_FALSE;
  depth.depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;
  VkPipelineColorBlendAttachmentState plain{};
  plain.colorWriteMask = 0xF;
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &plain;
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &view;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.layout = program->layout_;
  info.renderPass = state.render_pass;
  ZC_VK(vkCreateGraphicsPipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &program->pipeline_));
  program->destroy_modules();
  return program;
}

Program::~Program() {
  destroy_modules();
  vkDestroyPipeline(device_.handle(), pipeline_, nullptr);
  vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
  vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_.handle(), set_layout_, nullptr);
}

void Program::destroy_modules() {
  for (Stage& stage : stages_)
    vkDestroyShaderModule(device_.handle(), std::exchange(stage.module, VK_NULL_HANDLE), nullptr);
}

Status Program::add_stage(const char* name, std::span<const std::uint32_t> spirv, VkShaderStageFlagBits stage) {
  Result<ShaderInterface> read = reflect_shader(spirv);
  if (!read) return Error{read.error().code, std::string(name) + ": " + read.error().message};
  stages_.push_back({stage, VK_NULL_HANDLE, *std::move(read)});
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  return vk_status(vkCreateShaderModule(device_.handle(), &info, nullptr, &stages_.back().module),
                   "vkCreateShaderModule");
}

Status Program::check_limits(const char* name) const {
  const VkPhysicalDeviceLimits& limits = device_.limits();
  for (const Stage& stage : stages_) {
    const auto count = [&](VkDescriptorType type) {
      return static_cast<std::uint32_t>(
          std::ranges::count(stage.interface.bindings, type, &ShaderInterface::Binding::type));
    };
    struct Need {
      const char* limit;
      std::uint32_t needs, offers;
    };
    const std::array needs = {
        Need{"maxPerStageDescriptorStorageBuffers", count(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER),
             limits.maxPerStageDescriptorStorageBuffers},
        Need{"maxPerStageDescriptorUniformBuffers", count(VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER),
             limits.maxPerStageDescriptorUniformBuffers},
        Need{"maxPerStageDescriptorSampledImages",
             count(VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) + count(VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER),
             limits.maxPerStageDescriptorSampledImages},
        Need{"maxPerStageDescriptorStorageImages", count(VK_DESCRIPTOR_TYPE_STORAGE_IMAGE),
             limits.maxPerStageDescriptorStorageImages},
        Need{"maxPerStageResources", static_cast<std::uint32_t>(stage.interface.bindings.size()),
             limits.maxPerStageResources},
        Need{"maxPushConstantsSize", stage.interface.push_bytes, limits.maxPushConstantsSize},
        Need{"maxComputeWorkGroupInvocations",
             stage.interface.workgroup[0] * stage.interface.workgroup[1] * stage.interface.workgroup[2],
             limits.maxComputeWorkGroupInvocations},
    };
    for (const Need& need : needs)
      if (need.needs > need.offers)
        return Error{ErrorCode::kDevice, device_.name() + " offers a " + need.limit + " of " +
                                             std::to_string(need.offers) + ", and the shader " + name + " needs " +
                                             std::to_string(need.needs)};
  }
  return {};
}

Status Program::create_layout() {
  for (const Stage& stage : stages_) {
    for (const ShaderInterface::Binding& used : stage.interface.bindings) {
      const auto known = std::ranges::find(bindings_, used.binding, &VkDescriptorSetLayoutBinding::binding);
      if (known == bindings_.end())
        bindings_.push_back({used.binding, used.type, 1, static_cast<VkShaderStageFlags>(stage.bit), nullptr});
      else
        known->stageFlags |= static_cast<VkShaderStageFlags>(stage.bit);
    }
    if (stage.interface.push_bytes == 0) continue;
    push_stages_ |= static_cast<VkShaderStageFlags>(stage.bit);
    push_bytes_ = std::max(push_bytes_, stage.interface.push_bytes);
  }
  VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set.bindingCount = static_cast<std::uint32_t>(bindings_.size());
  set.pBindings = bindings_.data();
  ZC_VK(vkCreateDescriptorSetLayout(device_.handle(), &set, nullptr, &set_layout_));
  const VkPushConstantRange push{push_stages_, 0, push_bytes_};
  VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout_;
  layout.pushConstantRangeCount = push_bytes_ > 0 ? 1 : 0;
  layout.pPushConstantRanges = &push;
  ZC_VK(vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_));

  std::vector<VkDescriptorPoolSize> sizes;
  for (const VkDescriptorSetLayoutBinding& binding : bindings_)
    sizes.push_back({binding.descriptorType, kMaxFramesInFlight});
  if (sizes.empty()) sizes.push_back({VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1});
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = kMaxFramesInFlight;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  ZC_VK(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_));
  std::array<VkDescriptorSetLayout, kMaxFramesInFlight> layouts{};
  layouts.fill(set_layout_);
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = kMaxFramesInFlight;
  allocate.pSetLayouts = layouts.data();
  return vk_status(vkAllocateDescriptorSets(device_.handle(), &allocate, sets_.data()), "vkAllocateDescriptorSets");
}

std::vector<VkPipelineShaderStageCreateInfo> Program::stages(const VkSpecializationInfo& constants) const {
  std::vector<VkPipelineShaderStageCreateInfo> out;
  for (const Stage& stage : stages_) {
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = stage.bit;
    info.module = stage.module;
    info.pName = "main";
    info.pSpecializationInfo = &constants;
    out.push_back(info);
  }
  return out;
}

void Program::bind(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot) {
  const VkDescriptorSet set = sets_.at(slot);
  if (std::exchange(written_[slot], table.version()) != table.version()) {
    std::vector<VkWriteDescriptorSet> writes;
    for (const VkDescriptorSetLayoutBinding& binding : bindings_) {
      const BindingTable::Entry& entry = table.at(binding.binding);
      VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
      write.dstSet = set;
      write.dstBinding = binding.binding;
      write.descriptorCount = 1;
      write.descriptorType = binding.descriptorType;
      write.pBufferInfo = &entry.buffer;
      write.pTexelBufferView = &entry.texels;
      write.pImageInfo = &entry.image;
      writes.push_back(write);
    }
    vkUpdateDescriptorSets(device_.handle(), static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
  }
  vkCmdBindPipeline(commands, point_, pipeline_);
  vkCmdBindDescriptorSets(commands, point_, layout_, 0, 1, &set, 0, nullptr);
}

void Program::push(VkCommandBuffer commands, std::span<const std::byte> bytes) const {
  ZC_CHECK(bytes.size() == push_bytes_);
  vkCmdPushConstants(commands, layout_, push_stages_, 0, push_bytes_, bytes.data());
}

}  // namespace zc
