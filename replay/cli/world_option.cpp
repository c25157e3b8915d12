// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/world_option.h"

#include "replay/session/units.h"

namespace zc {

CLI::Option* add_world_option(CLI::App& command, WorldOption& world, const std::string& without) {
  const std::string what = "World: a folder, a .3tz archive, or the http(s) address of one of them";
  CLI::Option* place = command.add_option("world", world.place, without.empty() ? what : what + "; " + without);
  if (without.empty()) place->required();
  command.add_option("--cache", world.cache, "Folder that keeps what was read from a server");
  command
      .add_option("--cache-bytes", world.cache_bytes, "Limit of that folder; what was not used for longest goes first")
      ->capture_default_str();
  command.add_option("--timeout", world.timeout, "Limit of connecting to a server, and of its silence")
      ->capture_default_str();
  return place;
}

Result<SourceOptions> parse_source_options(const WorldOption& world) {
  SourceOptions options;
  options.cache = world.cache;
  ZC_ASSIGN(options.cache_bytes, parse_bytes(world.cache_bytes));
  ZC_ASSIGN(options.timeout_s, parse_seconds(world.timeout));
  if (options.timeout_s < 0.01 || options.timeout_s > 3600)
    return Error{ErrorCode::kArgument, "--timeout is from 10ms to 3600s, not '" + world.timeout + "'"};
  return options;
}

}  // namespace zc
