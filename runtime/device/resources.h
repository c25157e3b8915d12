// SPDX-License-Identifier: Apache-2.0
// A buffer with its views and an image, each with memory of its own: the runtime has few and long-lived ones.
// Borrows the device, which must outlive them. Threads: as the device.
#pragma once

#include <cstddef>
#include <span>

#include "runtime/device/device.h"

namespace zc {

enum class MemoryUse {
  kDevice,    // the GPU alone; mapped as well where the device offers that at no cost
  kUpload,    // written by the CPU, read by the GPU
  kReadback,  // written by the GPU, read by the CPU
};

class Buffer {
 public:
  static Result<Buffer> create(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use);
  Buffer() = default;
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer();

  [[nodiscard]] VkBuffer handle() const { return buffer_; }
  [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
  // Empty when the memory is not visible to the CPU.
  [[nodiscard]] std::span<std::byte> mapped() const { return {mapped_, mapped_ == nullptr ? 0 : bytes_}; }

 private:
  void swap(Buffer& other) noexcept;
  const Device* device_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize bytes_ = 0;
  VkDeviceSize allocated_bytes_ = 0;
  std::byte* mapped_ = nullptr;
};

// A buffer, or its first bytes, as a texel buffer; the buffer must outlive it.
class BufferView {
 public:
  static Result<BufferView> create(const Device& device, const Buffer& buffer, VkFormat format,
                                   VkDeviceSize bytes = VK_WHOLE_SIZE);
  BufferView() = default;
  BufferView(BufferView&& other) noexcept { swap(other); }
  BufferView& operator=(BufferView&& other) noexcept {
    swap(other);
    return *this;
  }
  BufferView(const BufferView&) = delete;
  BufferView& operator=(const BufferView&) = delete;
  ~BufferView();

  [[nodiscard]] VkBufferView handle() const { return view_; }

 private:
  void swap(BufferView& other) noexcept;
  const Device* device_ = nullptr;
  VkBufferView view_ = VK_NULL_HANDLE;
};

// A 2D image with one level and one view.
class Image {
 public:
  static Result<Image> create(const Device& device, std::uint32_t width, std::uint32_t height, VkFormat format,
                              VkImageUsageFlags usage, VkImageAspectFlags aspect);
  Image() = default;
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  ~Image();

  [[nodiscard]] VkImage handle() const { return image_; }
  [[nodiscard]] VkImageView view() const { return view_; }

 private:
  void swap(Image& other) noexcept;
  const Device* device_ = nullptr;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize allocated_bytes_ = 0;
};

}  // namespace zc
