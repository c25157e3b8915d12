// SPDX-License-Identifier: Apache-2.0
// One Vulkan device with one queue for graphics, compute and transfer. Needs Vulkan 1.2; what else it can turn on is
// asked for by a flag and may stay off.
// Owns: instance, device, command pool. Threads: one at a time. Fails when no device fits or the driver refuses.
#pragma once

#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/result.h"

namespace zc {

struct DeviceOptions {
  std::string name;  // part of the device's name, any case; empty: a discrete GPU if there is one, else the first
  bool validation = false;      // Khronos and synchronisation validation, and robust buffer access where it is offered
  bool ray_query = false;       // VK_KHR_ray_query and what it needs, where the device offers it
  bool subgroup_sizes = false;  // VK_EXT_subgroup_size_control, where the device offers it
};

// OK, or a kDevice error naming the call.
Status vk_status(VkResult result, const char* call);

class Device {
 public:
  static Result<std::unique_ptr<Device>> create(const DeviceOptions& options);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  [[nodiscard]] VkDevice handle() const { return device_; }
  [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return properties_.limits; }
  [[nodiscard]] bool is_cpu() const { return properties_.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& driver() const { return driver_; }
  // Milliseconds between two timestamps, which may wrap; 0 where the queue has none.
  [[nodiscard]] double elapsed_ms(std::uint64_t from_ticks, std::uint64_t to_ticks) const {
    return static_cast<double>((to_ticks - from_ticks) & timestamp_mask_) *
           static_cast<double>(properties_.limits.timestampPeriod) * 1e-6;
  }
  // Invocations of a subgroup in compute shaders; 0 where they cannot shuffle.
  [[nodiscard]] std::uint32_t subgroup_size() const { return subgroup_size_; }
  [[nodiscard]] bool has_timestamps() const { return timestamp_mask_ != 0; }
  // Whether compute shaders may use ray queries.
  [[nodiscard]] bool has_ray_query() const { return ray_query_; }
  // Subgroup sizes that a compute pipeline may require: powers of two from min to max; 0 where it may require none.
  [[nodiscard]] std::uint32_t min_subgroup_size() const { return min_subgroup_size_; }
  [[nodiscard]] std::uint32_t max_subgroup_size() const { return max_subgroup_size_; }
  // Warnings and errors of the validation layers so far; 0 when they are off.
  [[nodiscard]] std::uint64_t validation_messages() const { return validation_messages_; }

  // Memory that buffers and images took of it: now, and at most so far.
  [[nodiscard]] std::uint64_t allocated_bytes() const { return allocated_bytes_; }
  [[nodiscard]] std::uint64_t peak_allocated_bytes() const { return peak_allocated_bytes_; }
  void count_allocation(std::uint64_t bytes) const {
    allocated_bytes_ += bytes;
    peak_allocated_bytes_ = std::max(peak_allocated_bytes_, allocated_bytes_);
  }
  void count_free(std::uint64_t bytes) const { allocated_bytes_ -= bytes; }

  // Records commands, submits them and waits until they are done.
  Status run(const std::function<void(VkCommandBuffer)>& record);

  // A memory type out of type_bits with all of `required`, preferring one that also has `preferred`.
  Result<std::uint32_t> memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                                    VkMemoryPropertyFlags preferred) const;
  [[nodiscard]] VkMemoryPropertyFlags memory_flags(std::uint32_t type) const {
    return memory_.memoryTypes[type].propertyFlags;
  }

 private:
  Device() = default;
  Status create_instance(const DeviceOptions& options);
  Status pick(const DeviceOptions& options);
  Status create_device(const DeviceOptions& options);
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT type,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  std::uint64_t timestamp_mask_ = 0;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_ = {};
  VkPhysicalDeviceMemoryProperties memory_ = {};
  std::uint32_t subgroup_size_ = 0;
  std::string name_;
  std::string driver_;
  bool ray_query_ = false;
  std::uint32_t min_subgroup_size_ = 0;
  std::uint32_t max_subgroup_size_ = 0;
  std::uint64_t validation_messages_ = 0;
  mutable std::uint64_t allocated_bytes_ = 0;
  mutable std::uint64_t peak_allocated_bytes_ = 0;
};

}  // namespace zc

// Return the error of a Vulkan call from the enclosing function.
#define ZC_VK(call) ZC_TRY(::zc::vk_status((call), #call))
