// SPDX-License-Identifier: Apache-2.0
// A pipeline with its layout and its descriptor sets, all made from what its shaders say of themselves.
// Borrows the device. Threads: one at a time. Fails when a stage binds more than the device offers, which it names, or
// when the driver refuses.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/device/binding_table.h"
#include "runtime/device/device.h"
#include "runtime/device/shader_interface.h"

namespace zc {

inline constexpr std::uint32_t kMaxFramesInFlight = 4;

// Specialisation constants: constant_id is the index. Those that a shader does not declare have no effect.
using Constants = std::array<std::uint32_t, 12>;

// How what is drawn is drawn; all other state is fixed: no culling, one sample, depth test "greater or equal".
struct GraphicsState {
  VkRenderPass render_pass = VK_NULL_HANDLE;
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  bool depth_write = true;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

class Program {
 public:
  // name: for messages.
  static Result<std::unique_ptr<Program>> create_compute(Device& device, const char* name,
                                                         std::span<const std::uint32_t> spirv,
                                                         const Constants& constants);
  static Result<std::unique_ptr<Program>> create_graphics(Device& device, const char* name,
                                                          std::span<const std::uint32_t> vertex,
                                                          std::span<const std::uint32_t> fragment,
                                                          const GraphicsState& state, const Constants& constants);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  // Binds pipeline and descriptors. slot: the frame in flight, below kMaxFramesInFlight; its descriptors are rewritten
  // where the table changed, so the slot's last commands must have been executed.
  void bind(VkCommandBuffer commands, const BindingTable& table, std::uint32_t slot);
  // Of a bound program; `bytes` is as long as its shaders declare.
  void push(VkCommandBuffer commands, std::span<const std::byte> bytes) const;

  // Of a compute program: invocations of a workgroup, as its shader declares.
  [[nodiscard]] const std::array<std::uint32_t, 3>& workgroup() const { return stages_.front().interface.workgroup; }

 private:
  explicit Program(Device& device) : device_(device) {}
  Status add_stage(const char* name, std::span<const std::uint32_t> spirv, VkShaderStageFlagBits stage);
  Status check_limits(const char* name) const;
  Status create_layout();

  struct Stage {
    VkShaderStageFlagBits bit;
    VkShaderModule module;
    ShaderInterface interface;
  };
  [[nodiscard]] std::vector<VkPipelineShaderStageCreateInfo> stages(const VkSpecializationInfo& constants) const;
  void destroy_modules();

  Device& device_;
  std::vector<Stage> stages_;
  std::vector<VkDescriptorSetLayoutBinding> bindings_;
  VkShaderStageFlags push_stages_ = 0;
  std::uint32_t push_bytes_ = 0;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  std::array<VkDescriptorSet, kMaxFramesInFlight> sets_ = {};
  std::array<std::uint64_t, kMaxFramesInFlight> written_ = {};  // the table's version
  VkPipelineBindPoint point_ = VK_PIPELINE_BIND_POINT_COMPUTE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace zc
