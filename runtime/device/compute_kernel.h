// SPDX-License-Identifier: Apache-2.0
// One compute pipeline over N storage buffers (bindings 0 to N-1 of set 0), for work that stands by itself: kernels
// that are measured, tests.
// Borrows the device and what is bound to it, which must outlive its runs. Threads: as the device.
// Fails when the driver refuses the pipeline, or a buffer is longer than a storage range may be.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/device/device.h"
#include "runtime/device/resources.h"

namespace zc {

struct KernelOptions {
  std::span<const std::uint32_t> spirv;
  std::uint32_t buffers = 0;
  std::uint32_t push_bytes = 0;              // multiple of 4
  std::vector<std::uint32_t> constants;      // specialisation constants: constant_id is the index
  std::uint32_t required_subgroup_size = 0;  // 0: the driver's choice; else within Device's sizes
  bool acceleration_structure = false;       // one more binding, N
};

struct KernelTimes {
  double min_ms = 0;
  double median_ms = 0;
};

class ComputeKernel {
 public:
  static Result<std::unique_ptr<ComputeKernel>> create(Device& device, const KernelOptions& options);
  ComputeKernel(const ComputeKernel&) = delete;
  ComputeKernel& operator=(const ComputeKernel&) = delete;
  ~ComputeKernel();

  Status bind(std::uint32_t binding, const Buffer& buffer);
  void bind(VkAccelerationStructureKHR structure);

  // Dispatches groups_x × groups_y groups, `repetitions` times one after the other, and waits. Times are the device's
  // own, or wall clock around the submission where its queue has no timestamps. Earlier writes by the CPU are seen by
  // the kernel, and its writes by the CPU and by later copies.
  Result<KernelTimes> run(std::span<const std::byte> push, std::uint32_t groups_x, std::uint32_t groups_y = 1,
                          std::uint32_t repetitions = 1);

 private:
  explicit ComputeKernel(Device& device) : device_(device) {}
  Status create_layout(const KernelOptions& options);
  Status create_pipeline(const KernelOptions& options);
  Result<double> run_once(std::span<const std::byte> push, std::uint32_t groups_x, std::uint32_t groups_y);

  Device& device_;
  std::uint32_t buffers_ = 0;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout pipeline_layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkShaderModule module_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
};

}  // namespace zc
