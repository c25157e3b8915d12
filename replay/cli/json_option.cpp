// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/json_option.h"

#include <iostream>
#include <span>

#include "base/file.h"

namespace zc {

void add_json_option(CLI::App& command, JsonOption& json, CLI::Option* required) {
  const auto take = [&json, required](const std::string& word) {
    json.asked = true;
    if (required != nullptr && required->empty() && !word.empty() && word != "-") {
      required->add_result(word);
      required->run_callback();
    } else if (word != "-") {
      json.file = word;
    }
  };
  command
      .add_option_function<std::string>("--json", take,
                                        "Report as JSON: to FILE, or to standard output in place of the text")
      ->expected(0, 1)
      ->option_text("[FILE]");
}

Status write_json(const JsonOption& json, std::string_view text) {
  if (!json.asked) return {};
  std::string lines(text);
  if (!lines.ends_with('\n')) lines += '\n';
  if (!json.file.empty()) return write_file(json.file, std::as_bytes(std::span(lines)));
  std::cout << lines;
  return {};
}

}  // namespace zc
