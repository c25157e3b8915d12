// SPDX-License-Identifier: Apache-2.0
// The argument WORLD of the commands that read one, and the options of how it is read. As typed, and parsed when the
// command runs. Thread-safe: plain values.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/result.h"
#include "streamer/source/source.h"

namespace zc {

struct WorldOption {
  std::string place;  // empty: not given
  std::string cache;
  std::string cache_bytes = "1GiB";
  std::string timeout = "10s";
};

// `without`: what the command does when no world is named; empty: one must be. The positional.
CLI::Option* add_world_option(CLI::App& command, WorldOption& world, const std::string& without = {});
Result<SourceOptions> parse_source_options(const WorldOption& world);

}  // namespace zc
