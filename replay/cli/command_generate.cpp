// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "baker/generate/city.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"

namespace zc {

void add_generate(CLI::App& app, const SetCommand& set) {
  struct Arguments {
    GenerateOptions options;
    std::string out;
    JsonOption json;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("generate", "Write a deterministic city: city.glb, drive.csv, shots.json");
  command->add_option("--seed", arguments->options.seed, "Another seed, another city")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.8446744073709551e19))
      ->option_text("UINT [" + std::to_string(arguments->options.seed) + "]");
  command->add_option("--size-km", arguments->options.size_km, "Side of the square city in kilometres")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 20.0));
  command->add_option("-o,--output", arguments->out, "Folder to write to")->required();
  add_json_option(*command, arguments->json);
  command->callback([=] {
    set([=]() -> Status {
      ZC_ASSIGN(const GenerateReport report, generate_city(arguments->options, arguments->out));
      if (!arguments->json.replaces_text())
        std::cout << arguments->out << ": " << report.objects << " objects, " << report.triangles << " triangles\n";
      const nlohmann::ordered_json json = {
          {"folder", arguments->out}, {"objects", report.objects}, {"triangles", report.triangles}};
      return write_json(arguments->json, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    });
  });
}

}  // namespace zc
