// SPDX-License-Identifier: Apache-2.0
#include <pthread.h>
#include <signal.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/serve/world_server.h"

namespace zc {
namespace {

struct Arguments {
  std::string world, listen;
  JsonOption json;
  ServeOptions options;
};

// "ADDR:PORT", with an IPv6 address in brackets.
Status take_listen(const std::string& text, ServeOptions& options) {
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? std::string() : text.substr(colon + 1);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos || colon == 0 ||
      std::stoi(port) > 65535)
    return Error{ErrorCode::kArgument, "--listen takes ADDR:PORT, not '" + text + "'"};
  options.address = text.substr(0, colon);
  options.port = std::stoi(port);
  return {};
}

Status run(const Arguments& arguments) {
  ServeOptions options = arguments.options;
  if (!arguments.listen.empty()) ZC_TRY(take_listen(arguments.listen, options));
  ZC_ASSIGN(ServedWorld world, ServedWorld::open(arguments.world));
  const std::string end = world.address_end();
  ZC_ASSIGN(const std::unique_ptr<WorldServer> server, WorldServer::listen(std::move(world), options));

  // Every thread that comes leaves these signals to the one that waits for them.
  sigset_t signals;
  sigemptyset(&signals);
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, one);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  const bool bare = options.address.find(':') != std::string::npos && options.address.front() != '[';  // IPv6
  const std::string host = bare ? '[' + options.address + ']' : options.address;
  const std::string url = "http://" + host + ':' + std::to_string(server->port()) + '/' + end;
  const nlohmann::ordered_json report = {{"world", arguments.world}, {"url", url}};
  if (!arguments.json.replaces_text()) std::cout << arguments.world << ": at " << url << '\n';
  ZC_TRY(write_json(arguments.json, report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)));
  std::cout.flush();
  std::thread waiter([&] {
    int one = 0;
    sigwait(&signals, &one);
    server->stop();
  });
  server->run();
  pthread_kill(waiter.native_handle(), SIGTERM);  // when it ended by itself
  waiter.join();
  return {};
}

}  // namespace

void add_serve(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "serve", "Serve a world over HTTP: ranges, ETags, CORS, /metrics, /healthz; ends on SIGINT or SIGTERM");
  add_json_option(*command, a->json,
                  command->add_option("world", a->world, "World: a folder or a .3tz archive")->required());
  command->add_option("--bind", a->options.address, "Address to listen at; 0.0.0.0: all")->capture_default_str();
  command->add_option("--port", a->options.port, "Port; 0: any that is free")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535));
  command->add_option("--listen", a->listen, "Both in one, ADDR:PORT, in place of --bind and --port")
      ->excludes("--bind")
      ->excludes("--port");
  command->add_option("--connections", a->options.connections, "Limit of connections at once, a thread each")
      ->capture_default_str()
      ->check(CLI::Range(1U, 512U));
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
