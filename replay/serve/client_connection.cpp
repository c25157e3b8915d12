// SPDX-License-Identifier: Apache-2.0
#include "replay/serve/client_connection.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace zc {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSliceMs = 50;  // after which the server's state is looked at

int left_ms(Clock::time_point until) {
  return static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count());
}

bool same_name(std::string_view line, std::string_view lower_name) {
  return line.size() > lower_name.size() && line[lower_name.size()] == ':' &&
         std::equal(lower_name.begin(), lower_name.end(), line.begin(), [](char wanted, char c) {
           return wanted == (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c);
         });
}

// Lines end in CR LF and nothing else, and names end in their colon: what the library and we might read differently is
// no request (RFC 9112, sections 2.2 and 5.1). `head`: the request line and the headers.
bool has_sound_lines(std::string_view head) {
  for (bool is_first = true; !head.empty(); is_first = false) {
    const std::size_t end = head.find("\r\n");
    const std::string_view line = head.substr(0, end);
    if (line.find_first_of("\r\n") != std::string_view::npos) return false;
    if (!is_first) {
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos || colon == 0 || line.substr(0, colon).find_first_of(" \t") != line.npos)
        return false;
    }
    head.remove_prefix(end == std::string_view::npos ? head.size() : end + 2);
  }
  return true;
}

void name_of(const sockaddr_storage& address, socklen_t bytes, std::string& ip, int& port) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (::getnameinfo(reinterpret_cast<const sockaddr*>(&address), bytes, host.data(), host.size(), service.data(),
                    service.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return;
  ip = host.data();
  port = std::atoi(service.data());
}

}  // namespace

ClientConnection::ClientConnection(int socket, const ConnectionTimes& times, const std::atomic<ServerState>& server)
    : socket_(socket), times_(times), server_(server) {
  // Head and body are two writes: the second would wait until the client has acknowledged the first.
  const int yes = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

ClientConnection::~ClientConnection() {
  ::shutdown(socket_, SHUT_WR);
  // What the client still sends would turn the end into a reset, which can take the answer's last bytes with it.
  std::array<char, 4096> rest{};
  for (int i = 0; i < 16 && wait(POLLIN, kSliceMs); ++i)
    if (::recv(socket_, rest.data(), rest.size(), MSG_DONTWAIT) <= 0) break;
  ::close(socket_);
}

bool ClientConnection::wait(short events, int timeout_ms) const {
  pollfd one{socket_, events, 0};
  while (true) {
    const int ready = ::poll(&one, 1, std::max(timeout_ms, 0));
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0;
  }
}

ClientConnection::Next ClientConnection::next() {
  received_.erase(0, head_bytes_);
  head_bytes_ = read_ = 0;
  auto until = Clock::now() + std::chrono::milliseconds(received_.empty() ? times_.idle_ms : times_.request_ms);
  std::array<char, 4096> chunk{};
  while (true) {
    if (const std::size_t end = received_.find("\r\n\r\n"); end != std::string::npos) {
      head_bytes_ = end + 4;
      if (head_bytes_ > kHeaderLimitBytes) return Next::kTooLarge;
      if (!has_sound_lines(std::string_view(received_).substr(0, end))) return Next::kMalformed;
      prepare();
      return Next::kRequest;
    }
    if (received_.size() > kHeaderLimitBytes) return Next::kTooLarge;
    const int left = left_ms(until);
    if (left <= 0) return received_.empty() ? Next::kEnd : Next::kTooSlow;
    if (server_ != ServerState::kServing && received_.empty()) return Next::kEnd;
    if (!wait(POLLIN, std::min(left, kSliceMs))) continue;
    const ssize_t got = ::recv(socket_, chunk.data(), chunk.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Next::kEnd;
    if (received_.empty()) until = Clock::now() + std::chrono::milliseconds(times_.request_ms);
    received_.append(chunk.data(), static_cast<std::size_t>(got));
  }
}

void ClientConnection::prepare() {
  has_body_ = false;
  for (std::size_t at = received_.find("\r\n"); at + 2 < head_bytes_; at = received_.find("\r\n", at + 2)) {
    const std::string_view line = std::string_view(received_).substr(at + 2, head_bytes_ - at - 2);
    if (same_name(line, "range")) received_.replace(at + 2, std::strlen(kRangeHeader), kRangeHeader);
    if (same_name(line, "content-length") || same_name(line, "transfer-encoding")) has_body_ = true;
  }
}

ssize_t ClientConnection::read(char* out, std::size_t bytes) {
  const std::size_t count = std::min(bytes, head_bytes_ - read_);
  std::memcpy(out, received_.data() + read_, count);
  read_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t ClientConnection::write(const char* data, std::size_t bytes) {
  const auto until = Clock::now() + std::chrono::milliseconds(times_.write_ms);
  while (true) {
    const int left = left_ms(until);
    if (left <= 0 || server_ == ServerState::kEnded) return -1;
    if (!wait(POLLOUT, std::min(left, kSliceMs))) continue;
    const ssize_t put = ::send(socket_, data, bytes, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (put < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (put > 0) written_ += static_cast<std::uint64_t>(put);
    return put;
  }
}

void ClientConnection::refuse(std::string_view status_line) {
  const std::string answer = "HTTP/1.1 " + std::string(status_line) +
                             "\r\nConnection: close\r\nContent-Length: 0\r\nAccess-Control-Allow-Origin: *\r\n\r\n";
  (void)::send(socket_, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void ClientConnection::get_remote_ip_and_port(std::string& ip, int& port) const {
  sockaddr_storage address{};
  socklen_t bytes = sizeof address;
  if (::getpeername(socket_, reinterpret_cast<sockaddr*>(&address), &bytes) == 0) name_of(address, bytes, ip, port);
}

void ClientConnection::get_local_ip_and_port(std::string& ip, int& port) const {
  sockaddr_storage address{};
  socklen_t bytes = sizeof address;
  if (::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &bytes) == 0) name_of(address, bytes, ip, port);
}

}  // namespace zc
