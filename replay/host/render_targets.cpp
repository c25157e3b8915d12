// SPDX-License-Identifier: Apache-2.0
#include "replay/host/render_targets.h"

#include <array>
#include <span>
#include <vector>

#include "runtime/device/commands.h"

namespace zc {
namespace {

constexpr VkFormat kSurfaceFormat = VK_FORMAT_R32G32B32A32_UINT;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr VkFormat kLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
constexpr VkFormat kOverlayFormat = VK_FORMAT_R8G8B8A8_UNORM;

VkAttachmentDescription attachment(VkFormat format, VkAttachmentLoadOp load, VkImageLayout from, VkImageLayout to) {
  VkAttachmentDescription a{};
  a.format = format;
  a.samples = VK_SAMPLE_COUNT_1_BIT;
  a.loadOp = load;
  a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  a.initialLayout = from;
  a.finalLayout = to;
  return a;
}

// `attachments`: colours first, depth last. Everything before and after is ordered against the pass.
Result<VkRenderPass> make_render_pass(const Device& device, std::span<const VkAttachmentDescription> attachments) {
  std::vector<VkAttachmentReference> colors;
  const auto depth_index = static_cast<std::uint32_t>(attachments.size() - 1);
  for (std::uint32_t i = 0; i < depth_index; ++i) colors.push_back({i, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
  const VkAttachmentReference depth{depth_index, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = static_cast<std::uint32_t>(colors.size());
  subpass.pColorAttachments = colors.data();
  subpass.pDepthStencilAttachment = &depth;
  constexpr VkAccessFlags all = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  const std::array dependencies = {VkSubpassDependency{VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                                       VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT, all, all, 0},
                                   VkSubpassDependency{0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT,
                                                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, all, all, 0}};
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = static_cast<std::uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<std::uint32_t>(dependencies.size());
  info.pDependencies = dependencies.data();
  VkRenderPass pass = VK_NULL_HANDLE;
  ZC_VK(vkCreateRenderPass(device.handle(), &info, nullptr, &pass));
  return pass;
}

Result<VkFramebuffer> make_framebuffer(const Device& device, VkRenderPass pass, std::span<const VkImageView> views,
                                       std::uint32_t width, std::uint32_t height) {
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pass;
  info.attachmentCount = static_cast<std::uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = width;
  info.height = height;
  info.layers = 1;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  ZC_VK(vkCreateFramebuffer(device.handle(), &info, nullptr, &framebuffer));
  return framebuffer;
}

}  // namespace

RenderTargets::~RenderTargets() {
  if (device_ == nullptr) return;
  vkDestroySampler(device_->handle(), sampler, nullptr);
  vkDestroyFramebuffer(device_->handle(), gbuffer, nullptr);
  vkDestroyFramebuffer(device_->handle(), overlay_target, nullptr);
  vkDestroyRenderPass(device_->handle(), gbuffer_pass, nullptr);
  vkDestroyRenderPass(device_->handle(), overlay_pass, nullptr);
}

Status RenderTargets::create(Device& device, std::uint32_t width, std::uint32_t height) {
  device_ = &device;
  constexpr VkImageUsageFlags color = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags written =
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  constexpr VkImageUsageFlags copied =
      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  constexpr VkImageUsageFlags depth_usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  ZC_ASSIGN(surface, Image::create(device, width, height, kSurfaceFormat, color, VK_IMAGE_ASPECT_COLOR_BIT));
  ZC_ASSIGN(depth, Image::create(device, width, height, kDepthFormat, depth_usage, VK_IMAGE_ASPECT_DEPTH_BIT));
  ZC_ASSIGN(irradiance, Image::create(device, width, height, kLightFormat, written, VK_IMAGE_ASPECT_COLOR_BIT));
  ZC_ASSIGN(reflection, Image::create(device, width, height, kLightFormat, written, VK_IMAGE_ASPECT_COLOR_BIT));
  ZC_ASSIGN(overlay, Image::create(device, width, height, kOverlayFormat, copied, VK_IMAGE_ASPECT_COLOR_BIT));

  constexpr auto read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  const std::array gbuffer_images = {
      attachment(kSurfaceFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED, read),
      attachment(kDepthFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED, read)};
  ZC_ASSIGN(gbuffer_pass, make_render_pass(device, gbuffer_images));
  const std::array overlay_images = {
      attachment(kOverlayFormat, VK_ATTACHMENT_LOAD_OP_LOAD, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                 VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL),
      attachment(kDepthFormat, VK_ATTACHMENT_LOAD_OP_LOAD, read, read)};
  ZC_ASSIGN(overlay_pass, make_render_pass(device, overlay_images));
  const std::array gbuffer_views = {surface.view(), depth.view()};
  ZC_ASSIGN(gbuffer, make_framebuffer(device, gbuffer_pass, gbuffer_views, width, height));
  const std::array overlay_views = {overlay.view(), depth.view()};
  ZC_ASSIGN(overlay_target, make_framebuffer(device, overlay_pass, overlay_views, width, height));

  const VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  ZC_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  return device.run([&](VkCommandBuffer c) {
    constexpr VkClearColorValue black = {};
    constexpr VkImageSubresourceRange whole = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    for (const Image* image : {&irradiance, &reflection}) {
      change_layout(c, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
      vkCmdClearColorImage(c, image->handle(), VK_IMAGE_LAYOUT_GENERAL, &black, 1, &whole);
    }
  });
}

}  // namespace zc
