// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "baker/generate/city.h"
#include "replay/cli/commands.h"

namespace zc {

void add_generate(CLI::App& app, const SetCommand& set) {
  struct Arguments {
    GenerateOptions options;
    std::string out;
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
  command->callback([=] {
    set([=]() -> Status {
      ZC_ASSIGN(const GenerateReport report, generate_city(arguments->options, arguments->out));
      std::cout << arguments->out << ": " << report.objects << " objects, " << report.triangles << " triangles\n";
      return {};
    });
  });
}

}  // namespace zc
