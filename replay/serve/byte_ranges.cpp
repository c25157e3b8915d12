// SPDX-License-Identifier: Apache-2.0
#include "replay/serve/byte_ranges.h"

#include <algorithm>
#include <charconv>
#include <system_error>

namespace zc {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// All of the text; numbers beyond 64 bits are the largest.
std::optional<std::uint64_t> number(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  std::uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() ? value : UINT64_MAX;
}

// f(part) for each part between commas, until it is false.
template <class F>
bool each_part(std::string_view list, F&& f) {
  while (true) {
    const std::size_t comma = list.find(',');
    if (!f(trimmed(list.substr(0, comma)))) return false;
    if (comma == std::string_view::npos) return true;
    list.remove_prefix(comma + 1);
  }
}

}  // namespace

std::optional<std::vector<ByteRange>> parse_byte_ranges(std::string_view header, std::uint64_t file_bytes) {
  constexpr std::string_view kUnit = "bytes=";
  if (!header.starts_with(kUnit)) return std::nullopt;
  std::vector<ByteRange> ranges;
  std::size_t count = 0;
  const bool sound = each_part(header.substr(kUnit.size()), [&](std::string_view part) {
    const std::size_t dash = part.find('-');
    if (dash == std::string_view::npos || ++count > kMostRanges) return false;
    const std::string_view before = part.substr(0, dash);
    const std::string_view after = part.substr(dash + 1);
    const std::optional<std::uint64_t> from = number(before);
    const std::optional<std::uint64_t> to = number(after);
    if ((!from && !before.empty()) || (!to && !after.empty()) || (!from && !to) || (from && to && *from > *to))
      return false;
    if (!from) {  // the last so many
      if (*to > 0 && file_bytes > 0) ranges.push_back({file_bytes - std::min(*to, file_bytes), file_bytes - 1});
    } else if (*from < file_bytes) {
      ranges.push_back({*from, std::min(to.value_or(UINT64_MAX), file_bytes - 1)});
    }
    return true;
  });
  if (!sound) return std::nullopt;
  std::uint64_t all = 0;
  for (const ByteRange& range : ranges) {
    if (range.bytes() > file_bytes - all) return std::nullopt;
    all += range.bytes();
  }
  return ranges;
}

bool names_version(std::string_view if_none_match, std::string_view etag) {
  return !each_part(if_none_match, [&](std::string_view part) {
    if (part.starts_with("W/")) part.remove_prefix(2);
    return part != "*" && part != etag;
  });
}

}  // namespace zc
