// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/resources.h"

#include <utility>

namespace zc {

Result<Buffer> Buffer::create(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use) {
  Buffer buffer;
  buffer.device_ = &device;
  buffer.bytes_ = bytes;
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes;
  info.usage = usage;
  ZC_VK(vkCreateBuffer(device.handle(), &info, nullptr, &buffer.buffer_));
  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(device.handle(), buffer.buffer_, &needs);

  constexpr VkMemoryPropertyFlags mappable = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryPropertyFlags required = mappable;
  VkMemoryPropertyFlags preferred = 0;
  if (use == MemoryUse::kDevice) {
    // Without a CPU cache it is a discrete GPU's window: small on some, and slow to read on all.
    required = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    preferred = mappable | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  } else if (use == MemoryUse::kReadback) {
    preferred = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  }
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = needs.size;
  const VkMemoryAllocateFlagsInfo addressed{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, nullptr,
                                            VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  if ((usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0) allocate.pNext = &addressed;
  ZC_ASSIGN(allocate.memoryTypeIndex, device.memory_type(needs.memoryTypeBits, required, preferred));
  ZC_VK(vkAllocateMemory(device.handle(), &allocate, nullptr, &buffer.memory_));
  device.count_allocation(buffer.allocated_bytes_ = needs.size);
  ZC_VK(vkBindBufferMemory(device.handle(), buffer.buffer_, buffer.memory_, 0));
  if ((device.memory_flags(allocate.memoryTypeIndex) & mappable) == mappable) {
    void* address = nullptr;
    ZC_VK(vkMapMemory(device.handle(), buffer.memory_, 0, VK_WHOLE_SIZE, 0, &address));
    buffer.mapped_ = static_cast<std::byte*>(address);
  }
  return buffer;
}

void Buffer::swap(Buffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(bytes_, other.bytes_);
  std::swap(allocated_bytes_, other.allocated_bytes_);
  std::swap(mapped_, other.mapped_);
}

Buffer::~Buffer() {
  if (device_ == nullptr) return;
  vkDestroyBuffer(device_->handle(), buffer_, nullptr);
  vkFreeMemory(device_->handle(), memory_, nullptr);
  device_->count_free(allocated_bytes_);
}

Result<BufferView> BufferView::create(const Device& device, const Buffer& buffer, VkFormat format, VkDeviceSize bytes) {
  VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  info.buffer = buffer.handle();
  info.format = format;
  info.range = bytes;
  BufferView view;
  view.device_ = &device;
  ZC_VK(vkCreateBufferView(device.handle(), &info, nullptr, &view.view_));
  return view;
}

void BufferView::swap(BufferView& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(view_, other.view_);
}

BufferView::~BufferView() {
  if (device_ != nullptr) vkDestroyBufferView(device_->handle(), view_, nullptr);
}

Result<Image> Image::create(const Device& device, std::uint32_t width, std::uint32_t height, VkFormat format,
                            VkImageUsageFlags usage, VkImageAspectFlags aspect) {
  Image image;
  image.device_ = &device;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {width, height, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = usage;
  ZC_VK(vkCreateImage(device.handle(), &info, nullptr, &image.image_));
  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device.handle(), image.image_, &needs);
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = needs.size;
  ZC_ASSIGN(allocate.memoryTypeIndex, device.memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0));
  ZC_VK(vkAllocateMemory(device.handle(), &allocate, nullptr, &image.memory_));
  device.count_allocation(image.allocated_bytes_ = needs.size);
  ZC_VK(vkBindImageMemory(device.handle(), image.image_, image.memory_, 0));
  VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view.image = image.image_;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {aspect, 0, 1, 0, 1};
  ZC_VK(vkCreateImageView(device.handle(), &view, nullptr, &image.view_));
  return image;
}

void Image::swap(Image& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(image_, other.image_);
  std::swap(view_, other.view_);
  std::swap(memory_, other.memory_);
  std::swap(allocated_bytes_, other.allocated_bytes_);
}

Image::~Image() {
  if (device_ == nullptr) return;
  vkDestroyImageView(device_->handle(), view_, nullptr);
  vkDestroyImage(device_->handle(), image_, nullptr);
  vkFreeMemory(device_->handle(), memory_, nullptr);
  device_->count_free(allocated_bytes_);
}

}  // namespace zc
