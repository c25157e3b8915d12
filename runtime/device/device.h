// SPDX-License-Identifier: Apache-2.0
// One Vulkan device with one queue for graphics, compute and transfer: created here, or a host's own. Needs Vulkan 1.2;
// what else it can turn on is asked for by a flag and may stay off.
// Owns: a command pool and a pipeline cache; instance and device where it created them. Threads: one at a time.
// Fails when no device fits, lacks a limit (which it names), or the driver refuses.
#pragma once

#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
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
  std::filesystem::path pipeline_cache = {};  // file that compiled pipelines are kept in; empty: none
};

// What a host hands over; all of it outlives the Device made from it. apiVersion 1.2 or above must be enabled.
struct HostDevice {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;  // with compute and transfer
  VkQueue queue = VK_NULL_HANDLE;  // for Device::run alone, which no recording calls
  std::filesystem::path pipeline_cache = {};
};

// OK, or a kDevice error naming the call.
Status vk_status(VkResult result, const char* call);

class Device {
 public:
  static Result<std::unique_ptr<Device>> create(const DeviceOptions& options);
  static Result<std::unique_ptr<Device>> adopt(const HostDevice& host);
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

  [[nodiscard]] VkPipelineCache pipeline_cache() const { return pipeline_cache_; }
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
  Status read_properties();
  Status check_limits() const;
  Status create_commands();
  void set_timestamp_bits(std::uint32_t bits);
  Status open_cache(const std::filesystem::path& file);
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT type,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  bool is_adopted_ = false;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  std::uint64_t timestamp_mask_ = 0;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkPipelineCache pipeline_cache_ = VK_NULL_HANDLE;
  std::filesystem::path pipeline_cache_file_;
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
