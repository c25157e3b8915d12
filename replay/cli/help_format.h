// SPDX-License-Identifier: Apache-2.0
// The form of --help: lines of at most 110 columns, ranges of values left to the message of a value beyond.
// Thread-safe: no state.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace zc {

class HelpFormat : public CLI::Formatter {
 public:
  std::string make_description(const CLI::App* app) const override;
  std::string make_footer(const CLI::App* app) const override;
  std::string make_subcommand(const CLI::App* sub) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
};

}  // namespace zc
