// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/device.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <span>
#include <vector>

#include "base/text.h"
#include "runtime/device/pipeline_cache.h"

namespace zc {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool has_layer(const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::ranges::any_of(layers, [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

bool has_extensions(VkPhysicalDevice device, std::span<const char* const> names) {
  std::uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> found(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, found.data());
  return std::ranges::all_of(names, [&](const char* name) {
    return std::ranges::any_of(found, [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
  });
}

constexpr std::array kRayQueryExtensions = {VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                            VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                            VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
constexpr std::array kSubgroupExtensions = {VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME};

// Lower is better.
int rank(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    default:
      return 3;
  }
}

}  // namespace

Status vk_status(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return {};
  std::string_view what(call);
  what = what.substr(0, what.find('('));
  return Error{ErrorCode::kDevice, std::string(what) + " failed with VkResult " + std::to_string(result)};
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
  std::unique_ptr<Device> device(new Device());
  ZC_TRY(device->create_instance(options));
  ZC_TRY(device->pick(options));
  ZC_TRY(device->create_device(options));
  ZC_TRY(device->create_commands());
  ZC_TRY(device->open_cache(options.pipeline_cache));
  return device;
}

Result<std::unique_ptr<Device>> Device::adopt(const HostDevice& host) {
  std::unique_ptr<Device> device(new Device());
  device->is_adopted_ = true;
  device->physical_ = host.physical;
  device->device_ = host.device;
  device->queue_ = host.queue;
  device->queue_family_ = host.queue_family;
  vkGetPhysicalDeviceProperties(host.physical, &device->properties_);
  ZC_TRY(device->read_properties());
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(host.physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(host.physical, &count, families.data());
  if (host.queue_family >= count || (families[host.queue_family].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0)
    return Error{ErrorCode::kDevice,
                 device->name_ + ": queue family " + std::to_string(host.queue_family) + " cannot compute"};
  device->set_timestamp_bits(families[host.queue_family].timestampValidBits);
  ZC_TRY(device->create_commands());
  ZC_TRY(device->open_cache(host.pipeline_cache));
  return device;
}

Device::~Device() {
  if (device_ != VK_NULL_HANDLE) {
    vkDeviceWaitIdle(device_);
    keep_pipeline_cache(device_, pipeline_cache_, pipeline_cache_file_);
    vkDestroyPipelineCache(device_, pipeline_cache_, nullptr);
    vkDestroyFence(device_, fence_, nullptr);
    vkDestroyCommandPool(device_, pool_, nullptr);
    if (!is_adopted_) vkDestroyDevice(device_, nullptr);
  }
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

VKAPI_ATTR VkBool32 VKAPI_CALL Device::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT /*severity*/,
                                                  VkDebugUtilsMessageTypeFlagsEXT type,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
  // The loader's own remarks about the machine's drivers are not about our calls.
  if (type == VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT) return VK_FALSE;
  auto& count = static_cast<Device*>(self)->validation_messages_;
  if (++count <= 20) std::fprintf(stderr, "validation: %s\n", data->pMessage);
  return VK_FALSE;
}

Status Device::create_instance(const DeviceOptions& options) {
  VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  app.pApplicationName = "zonecast";
  app.apiVersion = VK_API_VERSION_1_2;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &app;

  const std::array features = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT validation{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  validation.enabledValidationFeatureCount = static_cast<std::uint32_t>(features.size());
  validation.pEnabledValidationFeatures = features.data();
  VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                          VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = &Device::on_message;
  messenger.pUserData = this;
  const char* layer = kValidationLayer;
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  if (options.validation) {
    if (!has_layer(layer)) return Error{ErrorCode::kDevice, "validation layers are not installed"};
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &layer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
    validation.pNext = &messenger;
    info.pNext = &validation;
  }
  ZC_VK(vkCreateInstance(&info, nullptr, &instance_));
  if (!options.validation) return {};
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  return vk_status(create(instance_, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
}

Status Device::pick(const DeviceOptions& options) {
  std::uint32_t count = 0;
  ZC_VK(vkEnumeratePhysicalDevices(instance_, &count, nullptr));
  std::vector<VkPhysicalDevice> found(count);
  ZC_VK(vkEnumeratePhysicalDevices(instance_, &count, found.data()));
  std::string seen;
  for (VkPhysicalDevice candidate : found) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(candidate, &properties);
    seen += (seen.empty() ? "" : ", ") + std::string(properties.deviceName);
    if (properties.apiVersion < VK_API_VERSION_1_2) continue;
    if (lower(properties.deviceName).find(lower(options.name)) == std::string::npos) continue;
    if (physical_ != VK_NULL_HANDLE && rank(properties.deviceType) >= rank(properties_.deviceType)) continue;
    physical_ = candidate;
    properties_ = properties;
  }
  if (physical_ == VK_NULL_HANDLE)
    return Error{ErrorCode::kDevice, "no Vulkan 1.2 device" +
                                         (options.name.empty() ? "" : " whose name contains '" + options.name + "'") +
                                         " (found: " + (seen.empty() ? "none" : seen) + ")"};
  return read_properties();
}

Status Device::read_properties() {
  if (properties_.apiVersion < VK_API_VERSION_1_2)
    return Error{ErrorCode::kDevice, std::string(properties_.deviceName) + " has no Vulkan 1.2"};
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  driver.pNext = &subgroup;
  VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  all.pNext = &driver;
  vkGetPhysicalDeviceProperties2(physical_, &all);
  const bool shuffles = (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0 &&
                        (subgroup.supportedOperations & VK_SUBGROUP_FEATURE_SHUFFLE_BIT) != 0;
  subgroup_size_ = shuffles ? subgroup.subgroupSize : 0;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  name_ = properties_.deviceName;
  driver_ = std::string(driver.driverName) + " " + driver.driverInfo;
  return check_limits();
}

// What no shader says of itself; programs check the rest as they are made.
Status Device::check_limits() const {
  struct Need {
    const char* limit;
    std::uint32_t needs, offers;
  };
  const VkPhysicalDeviceLimits& l = properties_.limits;
  const std::array needs = {
      Need{"maxStorageBufferRange", 1U << 27U, l.maxStorageBufferRange},
      Need{"maxTexelBufferElements", 1U << 16U, l.maxTexelBufferElements},
      Need{"maxComputeWorkGroupCount[0]", 65'535, l.maxComputeWorkGroupCount[0]},
      Need{"maxComputeWorkGroupCount[1]", 65'535, l.maxComputeWorkGroupCount[1]},
      Need{"maxComputeWorkGroupInvocations", 64, l.maxComputeWorkGroupInvocations},
      Need{"maxComputeSharedMemorySize", 16'384, l.maxComputeSharedMemorySize},
  };
  for (const Need& need : needs)
    if (need.offers < need.needs)
      return Error{ErrorCode::kDevice, name_ + " offers a " + need.limit + " of " + std::to_string(need.offers) +
                                           ", and at least " + std::to_string(need.needs) + " is needed"};
  return {};
}

Status Device::create_device(const DeviceOptions& options) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
  constexpr VkQueueFlags needed = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto family = std::ranges::find_if(families, [](const auto& f) { return (f.queueFlags & needed) == needed; });
  if (family == families.end()) return Error{ErrorCode::kDevice, name_ + " has no queue for both graphics and compute"};
  queue_family_ = static_cast<std::uint32_t>(family - families.begin());
  set_timestamp_bits(family->timestampValidBits);

  const float priority = 1.0F;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  std::vector<const char*> extensions;
  // One chain: asked what the device has, and given back to turn just that on.
  VkPhysicalDeviceBufferDeviceAddressFeatures addresses{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR, &addresses};
  VkPhysicalDeviceRayQueryFeaturesKHR queries{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, &structures};
  VkPhysicalDeviceSubgroupSizeControlFeaturesEXT subgroups{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES_EXT};
  if (options.ray_query && has_extensions(physical_, kRayQueryExtensions)) {
    VkPhysicalDeviceFeatures2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &queries};
    vkGetPhysicalDeviceFeatures2(physical_, &all);
    ray_query_ = queries.rayQuery == VK_TRUE && structures.accelerationStructure == VK_TRUE &&
                 addresses.bufferDeviceAddress == VK_TRUE;
  }
  if (ray_query_) {
    extensions.insert(extensions.end(), kRayQueryExtensions.begin(), kRayQueryExtensions.end());
    queries = {queries.sType, queries.pNext, VK_TRUE};
    structures = {structures.sType, structures.pNext, VK_TRUE};
    addresses = {addresses.sType, addresses.pNext, VK_TRUE};
    info.pNext = &queries;
  }
  if (options.subgroup_sizes && has_extensions(physical_, kSubgroupExtensions)) {
    VkPhysicalDeviceFeatures2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &subgroups};
    vkGetPhysicalDeviceFeatures2(physical_, &all);
    VkPhysicalDeviceSubgroupSizeControlPropertiesEXT sizes{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES_EXT};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &sizes};
    vkGetPhysicalDeviceProperties2(physical_, &properties);
    if (subgroups.subgroupSizeControl == VK_TRUE &&
        (sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0) {
      min_subgroup_size_ = sizes.minSubgroupSize;
      max_subgroup_size_ = sizes.maxSubgroupSize;
      extensions.insert(extensions.end(), kSubgroupExtensions.begin(), kSubgroupExtensions.end());
      subgroups.pNext = const_cast<void*>(info.pNext);
      info.pNext = &subgroups;
    }
  }
  VkPhysicalDeviceFeatures offered{};
  vkGetPhysicalDeviceFeatures(physical_, &offered);
  VkPhysicalDeviceFeatures on{};
  on.robustBufferAccess = options.validation ? offered.robustBufferAccess : VK_FALSE;
  info.pEnabledFeatures = &on;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  ZC_VK(vkCreateDevice(physical_, &info, nullptr, &device_));
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
  return {};
}

void Device::set_timestamp_bits(std::uint32_t bits) {
  timestamp_mask_ = bits >= 64 ? UINT64_MAX : (std::uint64_t{1} << bits) - 1;
}

Status Device::create_commands() {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = queue_family_;
  ZC_VK(vkCreateCommandPool(device_, &pool, nullptr, &pool_));
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  ZC_VK(vkAllocateCommandBuffers(device_, &allocate, &commands_));
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  return vk_status(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
}

Status Device::open_cache(const std::filesystem::path& file) {
  pipeline_cache_file_ = file;
  ZC_ASSIGN(pipeline_cache_, open_pipeline_cache(device_, file));
  return {};
}

Status Device::run(const std::function<void(VkCommandBuffer)>& record) {
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  ZC_VK(vkBeginCommandBuffer(commands_, &begin));
  record(commands_);
  ZC_VK(vkEndCommandBuffer(commands_));
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  ZC_VK(vkQueueSubmit(queue_, 1, &submit, fence_));
  ZC_VK(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX));
  return vk_status(vkResetFences(device_, 1, &fence_), "vkResetFences");
}

Result<std::uint32_t> Device::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags required,
                                          VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required}) {
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
      if ((type_bits >> i & 1U) != 0 && (memory_flags(i) & wanted) == wanted) return i;
    }
  }
  return Error{ErrorCode::kDevice, name_ + " has no memory type for this use"};
}

}  // namespace zc
