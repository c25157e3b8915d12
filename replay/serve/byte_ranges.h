// SPDX-License-Identifier: Apache-2.0
// What a request asks of a file: ranges of its bytes, and conditions on its version (RFC 9110, sections 8.8, 13 and
// 14). Pure. Untrusted input: any text is an answer.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace zc {

struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;  // inclusive
  [[nodiscard]] std::uint64_t bytes() const { return last - first + 1; }
};

// The ranges of a Range header that a file of file_bytes has, in their order. Nothing: the header is to be ignored,
// because it is malformed, of another unit, or asks for more than kMostRanges or together for more than the file.
// Empty: the file has none of them.
inline constexpr std::size_t kMostRanges = 16;
std::optional<std::vector<ByteRange>> parse_byte_ranges(std::string_view header, std::uint64_t file_bytes);

// Whether an If-None-Match header names the version.
bool names_version(std::string_view if_none_match, std::string_view etag);

}  // namespace zc
