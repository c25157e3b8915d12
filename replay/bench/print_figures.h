// SPDX-License-Identifier: Apache-2.0
// What the benches share in telling their figures. Fails when a file cannot be written.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/file.h"

namespace zc::bench {

// printf into a string; longer ones are cut.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> line{};
  const int length = std::snprintf(line.data(), line.size(), pattern, values...);
  return {line.data(), std::min(static_cast<std::size_t>(std::max(length, 0)), line.size() - 1)};
}

// At least one value.
inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

// The table to standard output, the JSON to the file that was asked for, or to standard output instead of the table: -.
inline Status print_figures(const std::string& table, const nlohmann::ordered_json& json,
                            const std::string& json_file) {
  if (json_file != "-") std::cout << table;
  if (json_file.empty()) return {};
  const std::string text = json.dump(2) + "\n";
  if (json_file != "-") return write_file(json_file, std::as_bytes(std::span(text)));
  std::cout << text;
  return {};
}

}  // namespace zc::bench
