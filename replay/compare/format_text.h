// SPDX-License-Identifier: Apache-2.0
// A short text from a printf pattern. Pure.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace zc {

// At most 159 characters.
template <class... Values>
std::string format_text(const char* pattern, Values... values) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace zc
