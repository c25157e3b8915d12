// SPDX-License-Identifier: Apache-2.0
// The one descriptor set layout of all passes (shaders/shared/frame.h) and the pipelines made from it.
// Borrows the device. Threads: as the device.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "runtime/device/device.h"
#include "shaders/shared/frame.h"

namespace zc {

// Specialisation constants, by constant_id.
struct PassVariant {
  std::int32_t stack_size = 64;
  std::uint32_t use_screen = 1;
  std::uint32_t trace_host = 0;
  std::uint32_t pool_path = 0;  // this and what follows but check_access and any_hit: see TraceVariant
  std::int32_t rays_per_lane = 4;
  std::uint32_t check_access = 0;  // 1: count reads outside the traced pages (page_fetch.glsl)
  std::uint32_t stack_shared = 0;
  std::uint32_t trace_width = 64;
  std::uint32_t any_hit = 0;       // 1: rays of the queue end at any hit (ray_queue.glsl)
  std::int32_t step_limit = 1900;  // nodes that a ray may visit: see TraceLimits
};

class PassLayout {
 public:
  explicit PassLayout(Device& device) : device_(device) {}
  PassLayout(const PassLayout&) = delete;
  PassLayout& operator=(const PassLayout&) = delete;
  ~PassLayout();
  Status create();

  void bind_buffer(std::uint32_t binding, VkBuffer buffer);
  void bind_texels(std::uint32_t binding, VkBufferView view);
  void bind_sampled(std::uint32_t binding, VkImageView view, VkImageLayout layout);

  [[nodiscard]] VkPipelineLayout pipeline_layout() const { return pipeline_layout_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }

 private:
  Device& device_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout pipeline_layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkSampler sampler_ = VK_NULL_HANDLE;
};

class Pipeline {
 public:
  static Result<Pipeline> create_compute(const Device& device, const PassLayout& layout,
                                         std::span<const std::uint32_t> spirv, const PassVariant& variant);
  struct Graphics {
    std::span<const std::uint32_t> vertex;
    std::span<const std::uint32_t> fragment;
    VkRenderPass render_pass = VK_NULL_HANDLE;
    PassVariant variant;
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    bool depth_write = true;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
  };
  static Result<Pipeline> create_graphics(const Device& device, const PassLayout& layout, const Graphics& graphics);

  Pipeline() = default;
  Pipeline(Pipeline&& other) noexcept { swap(other); }
  Pipeline& operator=(Pipeline&& other) noexcept {
    swap(other);
    return *this;
  }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;
  ~Pipeline();
  [[nodiscard]] VkPipeline handle() const { return pipeline_; }

 private:
  void swap(Pipeline& other) noexcept;
  const Device* device_ = nullptr;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace zc
