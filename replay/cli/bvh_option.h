// SPDX-License-Identifier: Apache-2.0
// The option that chooses a builder, for the commands that join the baker. Borrows `method`, which it fills in.
#pragma once

#include "baker/bvh/build_wide.h"
#include "replay/cli/choice_option.h"

namespace zc {

inline void add_bvh_option(CLI::App& command, BvhMethod& method, const char* text) {
  Choices<BvhMethod> known;
  for (const BvhMethodName& entry : bvh_methods()) known.emplace_back(entry.name, entry.method);
  add_choice_option(command, "--bvh", method, known, text, "auto");
}

}  // namespace zc
