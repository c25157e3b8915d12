// SPDX-License-Identifier: Apache-2.0
// Parses, calls, reports. Exit codes: 0 success, 1 failure, 2 bad arguments.
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/dup_filter_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <climits>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "base/platform.h"
#include "base/text.h"
#include "replay/cli/command_words.h"
#include "replay/cli/commands.h"
#include "replay/cli/help_format.h"

namespace {

// A line of the log is one line whatever names it quotes.
class PrintableMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const std::string text = zc::printable({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintableMessage>();
  }
};

int run(int argc, char** argv) {
  CLI::App app{
      "zonecast bakes a city into zones, pages them along a camera path under a hard memory cap, and traces "
      "reflections against the resident zones in Vulkan compute shaders."};
  app.name("zonecast");
  app.formatter(std::make_shared<zc::HelpFormat>());
  app.set_version_flag("--version", "zonecast " ZONECAST_VERSION);
  app.require_subcommand(1);
  std::function<zc::Status()> command;
  const zc::SetCommand set = [&](std::function<zc::Status()> chosen) { command = std::move(chosen); };
  zc::add_generate(app, set);
  zc::add_bake(app, set);
  zc::add_inspect(app, set);
  zc::add_pack(app, set);
  zc::add_serve(app, set);
  zc::add_caps(app, set);
  zc::add_compare(app, set);
  zc::add_replay(app, set);
  zc::add_bench(app, set);
  // Behind the commands, which would take it over.
  app.footer(
      "--json [FILE] of every command that reports: with FILE the report goes there as JSON, and the text to standard "
      "output; without, the JSON goes to standard output alone. `help COMMAND` is `COMMAND --help`. Exit codes: 0 "
      "success, "
      "1 failure, 2 bad arguments.");
  zc::Result<std::vector<std::string>> words = zc::resolve_command(app, {argv + 1, argv + argc});
  if (!words) {
    std::cerr << "zonecast: " << zc::printable(words.error().message) << '\n';
    return 2;
  }
  try {
    app.parse(std::vector<std::string>(words->rbegin(), words->rend()));  // it takes them from the back
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "zonecast: " << zc::printable(error.what()) << '\n';
    return 2;
  }
  const zc::Status status = command();
  if (status.ok()) {
    if (std::cout.flush()) return 0;
    std::cerr << "zonecast: standard output: cannot be written\n";
    return 1;
  }
  zc::Error shown = status.error();
  shown.path = zc::printable(shown.path, PATH_MAX);  // what the caller may want to copy
  shown.message = zc::printable(shown.message);
  std::cerr << "zonecast: " << shown.describe() << '\n';
  return status.error().code == zc::ErrorCode::kArgument ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  // Decode scratch goes back to the system when it is freed, so that the process holds what the ledger says.
  zc::return_freed_memory();
  // An archive that ends early fails page after page with the same words.
  const auto once = std::make_shared<spdlog::sinks::dup_filter_sink_mt>(std::chrono::hours(24));
  once->add_sink(std::make_shared<spdlog::sinks::stderr_sink_mt>());
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("zonecast", once));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableMessage>('*').set_pattern("%n: %l: %*");
  spdlog::set_formatter(std::move(formatter));
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::cerr << "zonecast: out of memory\n";
  } catch (const std::exception& error) {
    std::cerr << "zonecast: " << zc::printable(error.what()) << '\n';
  }
  return 1;
}
