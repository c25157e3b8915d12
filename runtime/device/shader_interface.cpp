// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/shader_interface.h"

#include <spirv_cross/spirv_cross_c.h>

#include <algorithm>
#include <memory>
#include <string>

namespace zc {
namespace {

struct Context {
  Context() { failed = spvc_context_create(&handle) != SPVC_SUCCESS; }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (!failed) spvc_context_destroy(handle);
  }
  spvc_context handle = nullptr;
  bool failed = false;
};

VkDescriptorType image_type(spvc_compiler compiler, const spvc_reflected_resource& resource, bool storage) {
  const spvc_type type = spvc_compiler_get_type_handle(compiler, resource.type_id);
  const bool texels = spvc_type_get_image_dimension(type) == SpvDimBuffer;
  if (storage) return texels ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  return texels ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

// Every call below fails in one way: the code is not what SPIRV-Cross reads.
bool read(spvc_context context, std::span<const std::uint32_t> spirv, ShaderInterface& out) {
  const auto ok = [](spvc_result result) { return result == SPVC_SUCCESS; };
  spvc_parsed_ir ir = nullptr;
  spvc_compiler compiler = nullptr;
  spvc_set active = nullptr;
  spvc_resources resources = nullptr;
  if (!ok(spvc_context_parse_spirv(context, spirv.data(), spirv.size(), &ir)) ||
      !ok(spvc_context_create_compiler(context, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler)) ||
      !ok(spvc_compiler_get_active_interface_variables(compiler, &active)) ||
      !ok(spvc_compiler_create_shader_resources_for_active_variables(compiler, &resources, active)))
    return false;

  struct Kind {
    spvc_resource_type list;
    VkDescriptorType type;
    bool is_image;
  };
  constexpr std::array kinds = {
      Kind{SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, false},
      Kind{SPVC_RESOURCE_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, false},
      Kind{SPVC_RESOURCE_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, true},
      Kind{SPVC_RESOURCE_TYPE_SAMPLED_IMAGE, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, true},
  };
  for (const Kind& kind : kinds) {
    const spvc_reflected_resource* list = nullptr;
    std::size_t count = 0;
    if (!ok(spvc_resources_get_resource_list_for_type(resources, kind.list, &list, &count))) return false;
    for (const spvc_reflected_resource& resource : std::span(list, count)) {
      const VkDescriptorType type =
          kind.is_image ? image_type(compiler, resource, kind.list == SPVC_RESOURCE_TYPE_STORAGE_IMAGE) : kind.type;
      out.bindings.push_back({spvc_compiler_get_decoration(compiler, resource.id, SpvDecorationBinding), type});
    }
  }
  std::ranges::sort(out.bindings, {}, &ShaderInterface::Binding::binding);

  const spvc_reflected_resource* push = nullptr;
  std::size_t push_count = 0;
  if (!ok(spvc_resources_get_resource_list_for_type(resources, SPVC_RESOURCE_TYPE_PUSH_CONSTANT, &push, &push_count)))
    return false;
  if (push_count > 0) {
    const spvc_type type = spvc_compiler_get_type_handle(compiler, push[0].base_type_id);
    std::size_t bytes = 0;
    if (!ok(spvc_compiler_get_declared_struct_size(compiler, type, &bytes))) return false;
    out.push_bytes = static_cast<std::uint32_t>(bytes);
  }

  const spvc_specialization_constant* constants = nullptr;
  std::size_t constant_count = 0;
  if (!ok(spvc_compiler_get_specialization_constants(compiler, &constants, &constant_count))) return false;
  for (std::size_t i = 0; i < constant_count; ++i) out.constant_ids.push_back(constants[i].constant_id);
  std::ranges::sort(out.constant_ids);

  std::array<spvc_specialization_constant, 3> specialised{};
  spvc_compiler_get_work_group_size_specialization_constants(compiler, &specialised[0], &specialised[1],
                                                             &specialised[2]);
  for (unsigned i = 0; i < 3; ++i)
    out.workgroup[i] = specialised[i].id != 0
                           ? 0
                           : spvc_compiler_get_execution_mode_argument_by_index(compiler, SpvExecutionModeLocalSize, i);
  return true;
}

}  // namespace

Result<ShaderInterface> reflect_shader(std::span<const std::uint32_t> spirv) {
  const Context context;
  ShaderInterface out;
  if (!context.failed && read(context.handle, spirv, out)) return out;
  const char* why = context.failed ? "no memory" : spvc_context_get_last_error_string(context.handle);
  return Error{ErrorCode::kDevice, std::string("a shader cannot be read: ") + why};
}

}  // namespace zc
