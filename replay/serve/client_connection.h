// SPDX-License-Identifier: Apache-2.0
// One client's connection as cpp-httplib reads and writes it, with the bounds that it lacks (0.11.4): a request's
// headers are read whole before it sees them, within a size and a time, so that no line without end grows memory and no
// drip of bytes holds a thread; and its own reading of Range headers, which takes any length for granted and knows no
// If-Range, is kept from happening. Owns the socket · threads: one.
#pragma once

#include <httplib.h>

#include <atomic>
#include <string>
#include <string_view>

namespace zc {

// The name under which a Range header reaches handlers.
inline constexpr const char* kRangeHeader = "Rang_";
inline constexpr std::size_t kHeaderLimitBytes = 16 << 10U;

struct ConnectionTimes {
  int idle_ms = 15'000;     // between requests
  int request_ms = 10'000;  // from a request's first byte to its last header
  int write_ms = 10'000;    // until the client takes more
};

enum class ServerState { kServing, kStopping, kEnded };

class ClientConnection final : public httplib::Stream {
 public:
  // `server`: idle connections end soon after it stops serving, those that are written to when it has ended.
  ClientConnection(int socket, const ConnectionTimes& times, const std::atomic<ServerState>& server);
  ClientConnection(const ClientConnection&) = delete;
  ClientConnection& operator=(const ClientConnection&) = delete;
  ~ClientConnection() override;

  enum class Next { kRequest, kEnd, kTooLarge, kTooSlow, kMalformed };
  // Waits for the next request's headers.
  Next next();
  // Whether the request has a body, which nobody will read: what follows is no request.
  [[nodiscard]] bool has_body() const { return has_body_; }
  [[nodiscard]] std::uint64_t written_bytes() const { return written_; }
  // An answer without a handler, and the end.
  void refuse(std::string_view status_line);

  [[nodiscard]] bool is_readable() const override { return true; }
  [[nodiscard]] bool is_writable() const override { return true; }
  ssize_t read(char* out, std::size_t bytes) override;  // of the request; 0 behind it
  ssize_t write(const char* data, std::size_t bytes) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  [[nodiscard]] bool wait(short events, int timeout_ms) const;
  void prepare();

  const int socket_;
  const ConnectionTimes times_;
  const std::atomic<ServerState>& server_;
  std::string received_;        // the request, and what came behind it
  std::size_t head_bytes_ = 0;  // of the request
  std::size_t read_ = 0;        // of them
  std::uint64_t written_ = 0;
  bool has_body_ = false;
};

}  // namespace zc
