// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/program_cache.h"

namespace zc {

Result<Program*> ProgramCache::compute(const char* name, std::span<const std::uint32_t> spirv,
                                       const Constants& constants) {
  auto known = constant_ids_.find(spirv.data());
  if (known == constant_ids_.end()) {
    ZC_ASSIGN(const ShaderInterface shader, reflect_shader(spirv));
    known = constant_ids_.emplace(spirv.data(), shader.constant_ids).first;
  }
  Key key{spirv.data(), {}};
  for (const std::uint32_t id : known->second)
    if (id < constants.size()) key.second[id] = constants[id];
  std::unique_ptr<Program>& program = programs_[key];
  if (program == nullptr) {
    ZC_ASSIGN(program, Program::create_compute(device_, name, spirv, constants));
  }
  return program.get();
}

}  // namespace zc
