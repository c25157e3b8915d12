// SPDX-License-Identifier: Apache-2.0
// Where the figures of a bench go: the table to standard output, the JSON to the file that was asked for, or to
// standard output instead of the table: -. Fails when the file cannot be written.
#pragma once

#include <iostream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "base/file.h"

namespace zc::bench {

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
