// SPDX-License-Identifier: Apache-2.0
// What a shader binds and is specialised by, read from its SPIR-V, so that no list beside the shader has to say it.
// Thread-safe: no state. Fails when the code is no SPIR-V that SPIRV-Cross reads.
#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

namespace zc {

struct ShaderInterface {
  struct Binding {
    std::uint32_t binding = 0;  // of descriptor set 0, the only one
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  };
  std::vector<Binding> bindings;            // that the entry point uses, by number
  std::uint32_t push_bytes = 0;             // of its push constants
  std::vector<std::uint32_t> constant_ids;  // of its specialisation constants
  // Of a compute shader, as declared; 0 where a specialisation constant decides.
  std::array<std::uint32_t, 3> workgroup = {};
};

Result<ShaderInterface> reflect_shader(std::span<const std::uint32_t> spirv);

}  // namespace zc
