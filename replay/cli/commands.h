// SPDX-License-Identifier: Apache-2.0
// The commands of the one binary. Each adds itself to the parser; when it was asked for, the parser calls `run` and its
// Status becomes the exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "base/result.h"

namespace zc {

using SetCommand = std::function<void(std::function<Status()>)>;

void add_generate(CLI::App& app, const SetCommand& set);
void add_pack(CLI::App& app, const SetCommand& set);
void add_bake(CLI::App& app, const SetCommand& set);
void add_inspect(CLI::App& app, const SetCommand& set);
void add_caps(CLI::App& app, const SetCommand& set);
void add_compare(CLI::App& app, const SetCommand& set);
void add_replay(CLI::App& app, const SetCommand& set);
void add_serve(CLI::App& app, const SetCommand& set);
void add_bench(CLI::App& app, const SetCommand& set);
void add_bench_build(CLI::App& bench, const SetCommand& set);
void add_bench_trace(CLI::App& bench, const SetCommand& set);
void add_bench_paging(CLI::App& app, const SetCommand& set);
void add_bench_top_level(CLI::App& bench, const SetCommand& set);

}  // namespace zc
