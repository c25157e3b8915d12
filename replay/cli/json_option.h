// SPDX-License-Identifier: Apache-2.0
// --json [FILE] of every command that reports: without FILE the report goes to standard output in place of the text;
// with FILE it goes there, and the text to standard output as ever. Fails when the file cannot be written. Thread-safe:
// plain values.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "base/result.h"

namespace zc {

struct JsonOption {
  bool asked = false;
  std::string file;  // empty: standard output

  [[nodiscard]] bool replaces_text() const { return asked && file.empty(); }
};

// `required`: the positional that the command cannot do without. A word behind --json is its value, and no FILE, where
// it would have none otherwise: `inspect --json WORLD`.
void add_json_option(CLI::App& command, JsonOption& json, CLI::Option* required = nullptr);
// Nothing where it was not asked for.
Status write_json(const JsonOption& json, std::string_view text);

}  // namespace zc
