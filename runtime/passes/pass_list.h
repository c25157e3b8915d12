// SPDX-License-Identifier: Apache-2.0
// All passes, in the order of the frame: those of the list PASSES in CMakeLists.txt. Thread-safe: no state.
#pragma once

#include <span>

#include "runtime/passes/pass.h"

namespace zc {

struct ListedPass {
  const char* name;  // of its file and its shader
  std::span<const std::uint32_t> (*spirv)();
  const Pass* pass;
};

std::span<const ListedPass> all_passes();

}  // namespace zc
