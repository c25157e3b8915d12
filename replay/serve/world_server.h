// SPDX-License-Identifier: Apache-2.0
// Serves a world over HTTP: its files with ranges, ETags and conditional requests, open to pages of any origin, and
// beside them /metrics (Prometheus) and /healthz. The library is cpp-httplib; what it does not bound is bounded here
// and in client_connection.h. Owns: the listening socket and its threads · threads: run() blocks one, stop() from any ·
// untrusted input: requests are bounded in size and time, connections in number; a client beyond that gets status 503.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "replay/serve/client_connection.h"
#include "replay/serve/served_world.h"

namespace zc {

struct ServeOptions {
  std::string address = "127.0.0.1";
  int port = 8080;  // 0: any that is free
  unsigned connections = 64;
  ConnectionTimes times;
};

class WorldServer {
 public:
  // Listens, so that clients can connect; they are answered from run() on. Fails when the address is not to be had.
  static Result<std::unique_ptr<WorldServer>> listen(ServedWorld world, const ServeOptions& options);
  ~WorldServer();
  WorldServer(const WorldServer&) = delete;
  WorldServer& operator=(const WorldServer&) = delete;

  [[nodiscard]] int port() const;
  // Until stop(): then new connections are refused, and requests under way get some seconds to end.
  void run();
  void stop();

 private:
  class Impl;
  explicit WorldServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace zc
