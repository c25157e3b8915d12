// SPDX-License-Identifier: Apache-2.0
// The option that chooses a builder, for the commands that join the baker. Borrows `method`, which it fills in.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "baker/bvh/build_wide.h"

namespace zc {

inline void add_bvh_option(CLI::App& command, BvhMethod& method, const char* text) {
  std::map<std::string, BvhMethod> known;
  std::string names;
  for (const BvhMethodName& entry : bvh_methods()) {
    known.emplace(entry.name, entry.method);
    names += (names.empty() ? "" : "|") + std::string(entry.name);
  }
  command.add_option("--bvh", method, text)->transform(CLI::CheckedTransformer(known))->option_text(names + " [auto]");
}

}  // namespace zc
