// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "replay/files/archive_writer.h"
#include "replay/session/units.h"
#include "streamer/open_source.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/index_file.h"

namespace zc {
namespace {

struct Arguments {
  WorldOption world;
  JsonOption json;
  std::string out;
};

Status run(const Arguments& arguments) {
  ZC_ASSIGN(const SourceOptions options, parse_source_options(arguments.world));
  ZC_ASSIGN(const auto source, open_source(arguments.world.place, options));
  ZC_ASSIGN(const WorldIndex index, read_world_index(*source, arguments.world.place));
  const std::filesystem::path out = arguments.out;
  if (out.extension() != ".3tz") return Error{ErrorCode::kArgument, "an archive's name ends in .3tz", arguments.out};
  std::error_code code;
  if (std::filesystem::equivalent(out, arguments.world.place, code))
    return Error{ErrorCode::kArgument, "an archive cannot be packed into itself", arguments.out};
  ZC_ASSIGN(ArchiveWriter writer, ArchiveWriter::create(out));
  // What a viewer or the streamer asks for first comes first; then every node's files side by side, coarse to fine.
  for (const char* name : {kWorldIndexName, "tileset.json", "bake.json"}) {
    ZC_ASSIGN(const std::vector<std::byte> bytes, source->read_all(name, std::uint64_t{1} << 31U));
    ZC_TRY(writer.add(name, bytes));
  }
  Progress progress;
  for (std::size_t i = 0; i < index.nodes.size(); ++i) {
    const NodeRecord& node = index.nodes[i];
    for (const WantedFile& file : page_files(node)) {
      ZC_ASSIGN(const std::vector<std::byte> bytes, source->read(file.name, file.bytes));
      ZC_TRY(check_wanted(bytes, file));
      ZC_TRY(writer.add(file.name, bytes));
    }
    progress.update(static_cast<double>(i + 1) / static_cast<double>(index.nodes.size()), "pack");
  }
  ZC_TRY(writer.commit());
  const std::uint64_t bytes = std::filesystem::file_size(out, code);
  if (!arguments.json.replaces_text())
    std::cout << arguments.out << ": " << index.nodes.size() << " nodes, " << format_bytes(bytes) << '\n';
  const nlohmann::ordered_json report = {{"archive", arguments.out}, {"nodes", index.nodes.size()}, {"bytes", bytes}};
  return write_json(arguments.json, report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace

void add_pack(CLI::App& app, const SetCommand& set) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("pack", "Put a world into one file, a 3D Tiles archive");
  add_json_option(*command, arguments->json, add_world_option(*command, arguments->world));
  command->add_option("-o,--output", arguments->out, "Archive to write, NAME.3tz")->required();
  command->callback([=] { set([=] { return run(*arguments); }); });
}

}  // namespace zc
