// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/command_words.h"

#include <algorithm>
#include <utility>

namespace zc {
namespace {

Error unknown_command(const CLI::App& app, const std::string& word) {
  std::string all, nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const CLI::App* command : app.get_subcommands({})) {
    const std::string& name = command->get_name();
    all += (all.empty() ? "" : ", ") + name;
    const std::size_t distance = edit_distance(word, name);
    if (distance < std::min(least, name.size())) {
      least = distance;
      nearest = name;
    }
  }
  const std::string parent = app.get_parent() == nullptr ? "" : app.get_name() + " ";
  return {ErrorCode::kArgument, "'" + parent + word + "' is no command" +
                                    (nearest.empty() ? "; there are " + all : "; did you mean '" + nearest + "'?")};
}

}  // namespace

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  }
  return cost[a.size()][b.size()];
}

Result<std::vector<std::string>> resolve_command(const CLI::App& app, std::vector<std::string> words) {
  const bool help = !words.empty() && words.front() == "help";
  if (help) words.erase(words.begin());
  const CLI::App* at = &app;
  std::size_t used = 0;
  for (; used < words.size() && !at->get_subcommands({}).empty() && !words[used].starts_with('-'); ++used) {
    // A longer word is no typing error, and takes time to compare.
    const std::string word = words[used].substr(0, 64);
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
