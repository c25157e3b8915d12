// SPDX-License-Identifier: Apache-2.0
// What lies behind each binding number of descriptor set 0, for all programs that are bound with the table. A program
// takes from it what its shaders use.
// Borrows what is put into it. Threads: one at a time.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>

namespace zc {

class BindingTable {
 public:
  static constexpr std::uint32_t kBindings = 32;
  struct Entry {
    VkDescriptorBufferInfo buffer = {VK_NULL_HANDLE, 0, VK_WHOLE_SIZE};
    VkBufferView texels = VK_NULL_HANDLE;
    VkDescriptorImageInfo image = {};
  };

  void set_buffer(std::uint32_t binding, VkBuffer buffer) { change(entries_.at(binding).buffer.buffer, buffer); }
  void set_texels(std::uint32_t binding, VkBufferView view) { change(entries_.at(binding).texels, view); }
  // sampler: of sampled images.
  void set_image(std::uint32_t binding, VkImageView view, VkImageLayout layout, VkSampler sampler = VK_NULL_HANDLE) {
    VkDescriptorImageInfo& image = entries_.at(binding).image;
    change(image.imageView, view);
    change(image.imageLayout, layout);
    change(image.sampler, sampler);
  }

  [[nodiscard]] const Entry& at(std::uint32_t binding) const { return entries_.at(binding); }
  // Another number whenever something in it is another one.
  [[nodiscard]] std::uint64_t version() const { return version_; }

 private:
  template <class Value>
  void change(Value& place, Value value) {
    if (place == value) return;
    place = value;
    ++version_;
  }

  std::array<Entry, kBindings> entries_;
  std::uint64_t version_ = 1;
};

}  // namespace zc
