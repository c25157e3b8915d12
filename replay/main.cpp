// SPDX-License-Identifier: Apache-2.0
// Parses, calls, reports. Exit codes: 0 success, 1 failure, 2 bad arguments.
#include <malloc.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <iostream>

#include "replay/commands.h"

namespace {

// Options can hold line breaks in values; an error is one line whatever it quotes.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return text;
}

int run(int argc, char** argv) {
  CLI::App app{
      "zonecast bakes a city into zones, pages them along a camera path under a hard memory cap, and traces "
      "reflections against the resident zones in Vulkan compute shaders."};
  app.name("zonecast");
  app.set_version_flag("--version", "zonecast " ZONECAST_VERSION);
  app.require_subcommand(1);
  std::function<zc::Status()> command;
  const zc::SetCommand set = [&](std::function<zc::Status()> chosen) { command = std::move(chosen); };
  zc::add_generate(app, set);
  zc::add_bake(app, set);
  zc::add_inspect(app, set);
  zc::add_pack(app, set);
  zc::add_serve(app, set);
  zc::add_compare(app, set);
  zc::add_replay(app, set);
  zc::add_bench(app, set);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "zonecast: " << one_line(error.what()) << '\n';
    return 2;
  }
  const zc::Status status = command();
  if (status.ok()) {
    if (std::cout.flush()) return 0;
    std::cerr << "zonecast: standard output: cannot be written\n";
    return 1;
  }
  std::cerr << "zonecast: " << one_line(status.error().describe()) << '\n';
  return status.error().code == zc::ErrorCode::kArgument ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  // Decode scratch goes back to the system when it is freed, so that the process holds what the ledger says.
  mallopt(M_MMAP_THRESHOLD, 1 << 16);
  mallopt(M_TRIM_THRESHOLD, 1 << 16);
  spdlog::set_default_logger(spdlog::stderr_logger_mt("zonecast"));
  spdlog::set_pattern("%n: %l: %v");
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::cerr << "zonecast: out of memory\n";
  } catch (const std::exception& error) {
    std::cerr << "zonecast: " << one_line(error.what()) << '\n';
  }
  return 1;
}
