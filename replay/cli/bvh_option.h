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
  const auto check = [=](std::string& word) {
    const auto found = known.find(word);
    if (found == known.end()) return "'" + word + "' is none of " + names;
    word = std::to_string(static_cast<int>(found->second));
    return std::string();
  };
  command.add_option("--bvh", method, text)->transform(CLI::Validator(check, ""))->option_text(names + " [auto]");
}

}  // namespace zc
