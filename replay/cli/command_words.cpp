// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/command_words.h"

#include <algorithm>
#include <utility>

#include "base/nearest_word.h"

namespace zc {
namespace {

Error unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  std::string all;
  for (const CLI::App* command : app.get_subcommands({})) {
    names.push_back(command->get_name());
    all += (all.empty() ? "" : ", ") + names.back();
  }
  const std::string parent = app.get_parent() == nullptr ? "" : app.get_name() + " ";
  const std::string meant = did_you_mean(word, names);
  return {ErrorCode::kArgument,
          "'" + parent + word + "' is no command" + (meant.empty() ? "; there are " + all : meant)};
}

}  // namespace

Result<std::vector<std::string>> resolve_command(const CLI::App& app, std::vector<std::string> words) {
  const bool help = !words.empty() && words.front() == "help";
  if (help) words.erase(words.begin());
  const CLI::App* at = &app;
  std::size_t used = 0;
  for (; used < words.size() && !at->get_subcommands({}).empty() && !words[used].starts_with('-'); ++used) {
    const std::string& word = words[used];
    const auto commands = at->get_subcommands({});
    const auto next = std::ranges::find(commands, word, &CLI::App::get_name);
    if (next == commands.end()) return unknown_command(*at, word);
    at = *next;
  }
  if (help) {
    words.resize(used);
    words.emplace_back("--help");
  }
  return words;
}

}  // namespace zc
