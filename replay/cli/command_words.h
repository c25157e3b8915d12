// SPDX-License-Identifier: Apache-2.0
// The words before any option: `help COMMAND` is `COMMAND --help`, and a command that there is none of is named, with
// the nearest one that there is. Thread-safe: no state.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

// Takes and returns the words of the command line without the program's name. Fails with kArgument.
Result<std::vector<std::string>> resolve_command(const CLI::App& app, std::vector<std::string> words);

}  // namespace zc
