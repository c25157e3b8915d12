// SPDX-License-Identifier: Apache-2.0
// UTF-8: RFC 3629.
#include "base/text.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace zc {
namespace {

// Bytes of the character that `text` begins with, 0 when it is no UTF-8. Sets its code point.
std::size_t character(std::string_view text, std::uint32_t& code) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t first = byte(0);
  code = first;
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : (first >= 0xE0 ? 3 : 2);
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  code = first & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeast[length] || code > 0x10FFFF || is_surrogate ? 0 : length;
}

// Moves the cursor, breaks the line, colours it or turns its direction.
bool is_control(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || (code >= 0x200E && code <= 0x200F) ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

std::string escaped(std::string_view bytes) {
  if (bytes == "\n") return "\\n";
  if (bytes == "\r") return "\\r";
  if (bytes == "\t") return "\\t";
  std::string out;
  for (const char c : bytes) {
    std::array<char, 5> hex{};
    std::snprintf(hex.data(), hex.size(), "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    out += hex.data();
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text, std::size_t most_bytes) {
  std::string out;
  std::vector<std::size_t> starts;  // of what is one on the screen
  while (!text.empty()) {
    std::uint32_t code = 0;
    const std::size_t length = character(text, code);
    const std::string_view bytes = text.substr(0, length == 0 ? 1 : length);
    starts.push_back(out.size());
    out += length == 0 || is_control(code) ? escaped(bytes) : std::string(bytes);
    text.remove_prefix(bytes.size());
  }
  if (out.size() <= most_bytes) return out;
  // The last start at or before the end of the head, the first within the tail.
  std::size_t head = 0;
  std::size_t tail = out.size();
  for (const std::size_t start : starts) {
    if (start <= most_bytes / 2) head = start;
    if (start >= out.size() - most_bytes / 2) {
      tail = start;
      break;
    }
  }
  return out.substr(0, head) + " … " + out.substr(tail);
}

}  // namespace zc
