// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/commands.h"

namespace zc {

void add_bench(CLI::App& app, const SetCommand& set) {
  CLI::App* command = app.add_subcommand("bench", "Measure against peers, in one run, on the same data");
  command->require_subcommand(1);
  add_bench_build(*command, set);
  add_bench_trace(*command, set);
  add_bench_top_level(*command, set);
  add_bench_paging(*command, set);
}

}  // namespace zc
