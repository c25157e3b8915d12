// SPDX-License-Identifier: Apache-2.0
// What engines on the Vulkan device share: rays and hits in buffers (shaders/bench/bench_rays.glsl), a kernel, its
// time.
// Borrows the device. Threads: as the device.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "replay/bench/engines/trace_engine.h"
#include "runtime/device/compute_kernel.h"

namespace zc::bench {

// A device-local storage buffer with this content, at least one word long.
Result<Buffer> make_filled_buffer(Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags more_usage = 0);

// Copies to and from a buffer made above, through a staging buffer where the CPU does not see its memory.
Status write_buffer(Device& device, const Buffer& buffer, std::span<const std::byte> bytes);
Status read_buffer(Device& device, const Buffer& buffer, std::span<std::byte> bytes);

// Gigabytes a second that large copies read and write in the device's memory, both counted.
Result<double> copy_gb_per_s(Device& device);

class GpuEngine : public TraceEngine {
 public:
  [[nodiscard]] BuildFigures figures() const override { return figures_; }
  Result<double> trace(std::span<const BenchRay> rays, std::span<BenchHit> hits) override;

 protected:
  GpuEngine(Device& device, bool any_hit) : device_(device), any_hit_(any_hit) {}
  [[nodiscard]] Device& device() { return device_; }

  // To be called by build(): a kernel whose bindings from 2 on are `data`, whose push constants are the number of rays
  // followed by `push`, and whose specialisation constants are kAnyHit followed by those in the options.
  Status set_kernel(KernelOptions options, std::vector<Buffer> data, std::vector<std::uint32_t> push = {});
  [[nodiscard]] ComputeKernel& kernel() { return *kernel_; }
  BuildFigures figures_;

 private:
  Device& device_;
  bool any_hit_;
  std::unique_ptr<ComputeKernel> kernel_;
  std::vector<Buffer> data_;
  std::vector<std::uint32_t> push_;
  Buffer rays_, hits_;
};

}  // namespace zc::bench
