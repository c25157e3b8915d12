// SPDX-License-Identifier: Apache-2.0
// The stand-in host's images: G-buffer, light, what is reflected, and lines drawn over a picture.
// Owns them. Borrows the device. Threads: as the device.
#pragma once

#include "runtime/device/resources.h"

namespace zc {

struct RenderTargets {
  RenderTargets() = default;
  RenderTargets(const RenderTargets&) = delete;
  RenderTargets& operator=(const RenderTargets&) = delete;
  ~RenderTargets();
  Status create(Device& device, std::uint32_t width, std::uint32_t height);

  Image depth, surface;          // readable by shaders after the G-buffer pass
  Image irradiance, reflection;  // RGBA16F, in layout GENERAL
  Image overlay;
  VkRenderPass gbuffer_pass = VK_NULL_HANDLE;
  VkRenderPass overlay_pass = VK_NULL_HANDLE;
  VkFramebuffer gbuffer = VK_NULL_HANDLE;
  VkFramebuffer overlay_target = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;

 private:
  Device* device_ = nullptr;
};

}  // namespace zc
