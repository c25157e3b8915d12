// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/pipelines.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace zc {
namespace {

constexpr std::uint32_t kBindingCount = gpu::kBindFallbackRays + 1;

VkDescriptorType type_of(std::uint32_t binding) {
  if (binding == gpu::kBindFrame) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  if (binding >= gpu::kBindProxyTexels && binding <= gpu::kBindRayTexels4)
    return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  if (binding == gpu::kBindDepth || binding == gpu::kBindSurface) return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

// A shader module lives only while its pipeline is made.
class ShaderModule {
 public:
  explicit ShaderModule(const Device& device) : device_(device) {}
  ShaderModule(const ShaderModule&) = delete;
  ShaderModule& operator=(const ShaderModule&) = delete;
  ~ShaderModule() { vkDestroyShaderModule(device_.handle(), module_, nullptr); }
  Status create(std::span<const std::uint32_t> spirv) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = spirv.size_bytes();
    info.pCode = spirv.data();
    return vk_status(vkCreateShaderModule(device_.handle(), &info, nullptr, &module_), "vkCreateShaderModule");
  }
  [[nodiscard]] VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits bit) const {
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = bit;
    info.module = module_;
    info.pName = "main";
    return info;
  }

 private:
  const Device& device_;
  VkShaderModule module_ = VK_NULL_HANDLE;
};

constexpr std::array kVariantEntries = {VkSpecializationMapEntry{0, offsetof(PassVariant, stack_size), 4},
                                        VkSpecializationMapEntry{1, offsetof(PassVariant, use_screen), 4},
                                        VkSpecializationMapEntry{2, offsetof(PassVariant, trace_host), 4},
                                        VkSpecializationMapEntry{3, offsetof(PassVariant, pool_path), 4},
                                        VkSpecializationMapEntry{4, offsetof(PassVariant, rays_per_lane), 4},
                                        VkSpecializationMapEntry{5, offsetof(PassVariant, check_access), 4},
                                        VkSpecializationMapEntry{6, offsetof(PassVariant, stack_shared), 4},
                                        VkSpecializationMapEntry{7, offsetof(PassVariant, trace_width), 4},
                                        VkSpecializationMapEntry{8, offsetof(PassVariant, any_hit), 4},
                                        VkSpecializationMapEntry{9, offsetof(PassVariant, step_limit), 4}};

VkSpecializationInfo specialization(const PassVariant& variant) {
  return {static_cast<std::uint32_t>(kVariantEntries.size()), kVariantEntries.data(), sizeof(variant), &variant};
}

}  // namespace

PassLayout::~PassLayout() {
  vkDestroySampler(device_.handle(), sampler_, nullptr);
  vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
  vkDestroyPipelineLayout(device_.handle(), pipeline_layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_.handle(), set_layout_, nullptr);
}

Status PassLayout::create() {
  std::vector<VkDescriptorSetLayoutBinding> bindings(kBindingCount);
  for (std::uint32_t i = 0; i < kBindingCount; ++i) {
    // What draws reads zones, pages and materials; everything else is for compute.
    const bool drawn = i <= gpu::kBindMaterials || (i >= gpu::kBindProxyTexels && i <= gpu::kBindHostTexels4);
    const VkShaderStageFlags stages =
        drawn ? VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT
              : VK_SHADER_STAGE_COMPUTE_BIT;
    bindings[i] = {i, type_of(i), 1, stages, nullptr};
  }
  VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  layout.bindingCount = kBindingCount;
  layout.pBindings = bindings.data();
  ZC_VK(vkCreateDescriptorSetLayout(device_.handle(), &layout, nullptr, &set_layout_));

  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT, 0,
                                 sizeof(gpu::PassConstants)};
  VkPipelineLayoutCreateInfo pipeline{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  pipeline.setLayoutCount = 1;
  pipeline.pSetLayouts = &set_layout_;
  pipeline.pushConstantRangeCount = 1;
  pipeline.pPushConstantRanges = &push;
  ZC_VK(vkCreatePipelineLayout(device_.handle(), &pipeline, nullptr, &pipeline_layout_));

  const std::array sizes = {VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
                            VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kBindingCount},
                            VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 5},
                            VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2}};
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = 1;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  ZC_VK(vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_));
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout_;
  ZC_VK(vkAllocateDescriptorSets(device_.handle(), &allocate, &set_));

  VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  sampler.addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  return vk_status(vkCreateSampler(device_.handle(), &sampler, nullptr, &sampler_), "vkCreateSampler");
}

void PassLayout::bind_buffer(std::uint32_t binding, VkBuffer buffer) {
  const VkDescriptorBufferInfo info{buffer, 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = type_of(binding);
  write.pBufferInfo = &info;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

void PassLayout::bind_texels(std::uint32_t binding, VkBufferView view) {
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = type_of(binding);
  write.pTexelBufferView = &view;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

void PassLayout::bind_sampled(std::uint32_t binding, VkImageView view, VkImageLayout layout) {
  const VkDescriptorImageInfo info{sampler_, view, layout};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.dstBinding = binding;
  write.descriptorCount = 1;
  write.descriptorType = type_of(binding);
  write.pImageInfo = &info;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

Result<Pipeline> Pipeline::create_compute(const Device& device, const PassLayout& layout,
                                          std::span<const std::uint32_t> spirv, const PassVariant& variant) {
  ShaderModule module(device);
  ZC_TRY(module.create(spirv));
  const VkSpecializationInfo special = specialization(variant);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = module.stage(VK_SHADER_STAGE_COMPUTE_BIT);
  info.stage.pSpecializationInfo = &special;
  info.layout = layout.pipeline_layout();
  Pipeline pipeline;
  pipeline.device_ = &device;
  ZC_VK(vkCreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.pipeline_));
  return pipeline;
}

Result<Pipeline> Pipeline::create_graphics(const Device& device, const PassLayout& layout, const Graphics& graphics) {
  ShaderModule vertex(device);
  ShaderModule fragment(device);
  ZC_TRY(vertex.create(graphics.vertex));
  ZC_TRY(fragment.create(graphics.fragment));
  std::array stages = {vertex.stage(VK_SHADER_STAGE_VERTEX_BIT), fragment.stage(VK_SHADER_STAGE_FRAGMENT_BIT)};
  const VkSpecializationInfo special = specialization(graphics.variant);
  for (auto& stage : stages) stage.pSpecializationInfo = &special;

  const VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = graphics.topology;
  const VkViewport viewport{0, 0, static_cast<float>(graphics.width), static_cast<float>(graphics.height), 0, 1};
  const VkRect2D scissor{{0, 0}, {graphics.width, graphics.height}};
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
  depth.depthWriteEnable = graphics.depth_write ? VK_TRUE : VK_FALSE;
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
  info.layout = layout.pipeline_layout();
  info.renderPass = graphics.render_pass;
  Pipeline pipeline;
  pipeline.device_ = &device;
  ZC_VK(vkCreateGraphicsPipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.pipeline_));
  return pipeline;
}

void Pipeline::swap(Pipeline& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(pipeline_, other.pipeline_);
}

Pipeline::~Pipeline() {
  if (device_ != nullptr) vkDestroyPipeline(device_->handle(), pipeline_, nullptr);
}

}  // namespace zc
