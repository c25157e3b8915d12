// SPDX-License-Identifier: Apache-2.0
// Small things done to text. Thread-safe: no state.
#pragma once

#include <string>
#include <string_view>

namespace zc {

// ASCII alone, whatever the locale.
inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

// Takes `word` off the front, where it is there.
inline bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

}  // namespace zc
