// SPDX-License-Identifier: Apache-2.0
// Choosing engines by name, for whatever list of entries with a `name` a bench has. Thread-safe: no state.
#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "base/nearest_word.h"
#include "base/result.h"

namespace zc::bench {

// OK, or an error that names the first unknown engine and the known ones.
template <class Entries>
Status check_names(const Entries& entries, std::span<const std::string> names) {
  for (const std::string& name : names) {
    if (std::ranges::any_of(entries, [&](const auto& entry) { return entry.name == name; })) continue;
    std::vector<std::string> names_known;
    std::string known;
    for (const auto& entry : entries) {
      names_known.emplace_back(entry.name);
      known += (known.empty() ? "" : ", ") + names_known.back();
    }
    return Error{ErrorCode::kArgument,
                 "no engine is called '" + name + "' (known: " + known + ")" + did_you_mean(name, names_known)};
  }
  return {};
}

// Those of known names in that order, each once; all where nothing was asked for. Borrows the entries.
template <class Entries>
auto choose_by_name(const Entries& entries, std::span<const std::string> names) {
  std::vector<decltype(&*std::begin(entries))> chosen;
  for (const std::string& name : names) {
    const auto* entry = &*std::ranges::find_if(entries, [&](const auto& e) { return e.name == name; });
    if (std::ranges::find(chosen, entry) == chosen.end()) chosen.push_back(entry);
  }
  if (names.empty())
    for (const auto& entry : entries) chosen.push_back(&entry);
  return chosen;
}

}  // namespace zc::bench
