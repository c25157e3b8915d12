// SPDX-License-Identifier: Apache-2.0
// Small things done to text. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace zc {

inline constexpr std::size_t kPrintableBytes = 600;

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

// What a file, a server or a caller said, as one line that a terminal can show: control characters, directions and
// bytes that are no UTF-8 as \n, \t or \x1b; of what then takes more than most_bytes, both ends.
std::string printable(std::string_view text, std::size_t most_bytes = kPrintableBytes);

}  // namespace zc
