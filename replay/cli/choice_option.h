// SPDX-License-Identifier: Apache-2.0
// An option with a value of a few: a word that is none of them is named with those that there are and the nearest one.
// Borrows the value, which it fills in.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/nearest_word.h"

namespace zc {

template <class Enum>
using Choices = std::vector<std::pair<std::string, Enum>>;

// `value`: an Enum, or a vector of them. The default's name is shown where there is one.
template <class Enum, class Value>
CLI::Option* add_choice_option(CLI::App& command, const std::string& name, Value& value, const Choices<Enum>& choices,
                               const std::string& text, const std::string& default_name = {}) {
  std::vector<std::string> names;
  std::string all;
  for (const auto& choice : choices) {
    names.push_back(choice.first);
    all += (all.empty() ? "" : "|") + choice.first;
  }
  const auto check = [=](std::string& word) {
    for (const auto& [known, meant] : choices) {
      if (word != known) continue;
      word = std::to_string(static_cast<int>(meant));
      return std::string();
    }
    return "'" + word + "' is none of " + all + did_you_mean(word, names);
  };
  return command.add_option(name, value, text)
      ->transform(CLI::Validator(check, ""))
      ->option_text(all + (default_name.empty() ? "" : " [" + default_name + "]"));
}

}  // namespace zc
