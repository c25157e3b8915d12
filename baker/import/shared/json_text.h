// SPDX-License-Identifier: GPL-3.0-or-later
// JSON from outside: parsing that ends in an Error with a byte offset, and lookups that never throw.
// Untrusted input. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

// `base_offset` is the place of `text` in the file at `path`. Fails on malformed or too deeply nested text.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& path, std::int64_t base_offset = 0);

// The same for text whose values may take so much memory and no more, by an estimate that is made before: a value is
// many times as large as its text. Fails beyond.
inline constexpr std::uint64_t kMaxSmallJsonBytes = std::uint64_t{1} << 29U;
Result<nlohmann::json> parse_small_json(std::string_view text, const std::string& path, std::int64_t base_offset = 0);

// Whether the outermost object of `text` has this member, without parsing the whole; malformed text gives any answer.
bool has_top_level_key(std::string_view text, std::string_view key);

// The member, or null when `object` is no object, has no such member, or has it as JSON null.
const nlohmann::json* find_member(const nlohmann::json& object, const char* key);

// A non-negative integer; nothing for any other value.
std::optional<std::uint64_t> as_unsigned(const nlohmann::json& value);

// An array of `count` numbers; nothing for any other value.
std::optional<std::vector<double>> as_numbers(const nlohmann::json& value, std::size_t count);

// A library's message as one line of printable text, cut to a length that a terminal shows.
std::string one_line(std::string_view text);

}  // namespace zc
