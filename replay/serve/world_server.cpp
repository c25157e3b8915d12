// SPDX-License-Identifier: Apache-2.0
#include "replay/serve/world_server.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "replay/serve/byte_ranges.h"
#include "replay/serve/serve_metrics.h"

namespace zc {
namespace {

using Clock = std::chrono::steady_clock;
using httplib::Request;
using httplib::Response;

constexpr int kBacklog = 128;  // the library's is 5
constexpr std::size_t kChunkBytes = 256 << 10U;
constexpr auto kLastRequests = std::chrono::seconds(5);
constexpr const char* kBoundary = "zonecast_byte_range_boundary";

// Answers carry their bodies this way: the library compresses what it is given as a string.
void set_text(Response& response, int status, std::string text, const char* type = "text/plain; charset=utf-8") {
  response.status = status;
  const std::size_t bytes = text.size();
  response.set_content_provider(bytes, type,
                                [text = std::move(text)](std::size_t at, std::size_t, httplib::DataSink& sink) {
                                  return sink.write(text.data() + at, text.size() - at);
                                });
}

// A part of a body: words of ours, then bytes of the file.
struct BodyPart {
  std::string words;
  std::uint64_t first = 0;
  std::uint64_t bytes = 0;
};

std::uint64_t size_of(const std::vector<BodyPart>& parts) {
  std::uint64_t sum = 0;
  for (const BodyPart& part : parts) sum += part.words.size() + part.bytes;
  return sum;
}

// One piece of the body from `at` on.
bool send_piece(const ServedFile& file, const std::vector<BodyPart>& parts, std::uint64_t at, httplib::DataSink& sink) {
  for (const BodyPart& part : parts) {
    if (at < part.words.size()) return sink.write(part.words.data() + at, part.words.size() - at);
    at -= part.words.size();
    if (at < part.bytes) {
      std::vector<char> chunk(std::min<std::uint64_t>(kChunkBytes, part.bytes - at));
      return file.read(part.first + at, chunk) == chunk.size() && sink.write(chunk.data(), chunk.size());
    }
    at -= part.bytes;
  }
  return false;
}

// What is answered to what is no request.
std::pair<int, const char*> refusal_of(ClientConnection::Next next) {
  if (next == ClientConnection::Next::kTooLarge) return {431, "431 Request Header Fields Too Large"};
  if (next == ClientConnection::Next::kTooSlow) return {408, "408 Request Timeout"};
  return {400, "400 Bad Request"};
}

std::string content_range(const ByteRange& range, std::uint64_t bytes) {
  return "bytes " + std::to_string(range.first) + "-" + std::to_string(range.last) + "/" + std::to_string(bytes);
}

void answer_file(const Request& request, Response& response, ServedFile found) {
  const auto file = std::make_shared<ServedFile>(std::move(found));
  response.set_header("ETag", file->etag());
  response.set_header("Accept-Ranges", "bytes");
  response.set_header("Cache-Control", "no-cache");  // keep it, but ask whether it is still right
  if (request.has_header("If-None-Match") && names_version(request.get_header_value("If-None-Match"), file->etag())) {
    response.status = 304;
    response.set_header("Content-Length", std::to_string(file->bytes()));
    return;
  }
  std::optional<std::vector<ByteRange>> ranges;
  const bool same = !request.has_header("If-Range") || request.get_header_value("If-Range") == file->etag();
  if (same && request.has_header(kRangeHeader))
    ranges = parse_byte_ranges(request.get_header_value(kRangeHeader), file->bytes());

  std::string type = file->type();
  std::vector<BodyPart> parts;
  response.status = 206;
  if (!ranges) {
    response.status = 200;
    parts.push_back({{}, 0, file->bytes()});
  } else if (ranges->empty()) {
    response.set_header("Content-Range", "bytes */" + std::to_string(file->bytes()));
    return set_text(response, 416, "the file has no such range\n");
  } else if (ranges->size() == 1) {
    response.set_header("Content-Range", content_range(ranges->front(), file->bytes()));
    parts.push_back({{}, ranges->front().first, ranges->front().bytes()});
  } else {
    for (const ByteRange& range : *ranges)
      parts.push_back({(parts.empty() ? "--" : "\r\n--") + std::string(kBoundary) + "\r\nContent-Type: " + type +
                           "\r\nContent-Range: " + content_range(range, file->bytes()) + "\r\n\r\n",
                       range.first, range.bytes()});
    parts.push_back({"\r\n--" + std::string(kBoundary) + "--\r\n", 0, 0});
    type = "multipart/byteranges; boundary=" + std::string(kBoundary);
  }
  const std::uint64_t bytes = size_of(parts);
  if (bytes == 0) return response.set_header("Content-Type", type);
  response.set_content_provider(bytes, type,
                                [file, parts = std::move(parts)](std::size_t at, std::size_t, httplib::DataSink& sink) {
                                  return send_piece(*file, parts, at, sink);
                                });
}

// A connection beyond the limit is given to the accepting thread itself, which refuses it.
thread_local bool refuse_connection = false;

class BoundedThreads final : public httplib::TaskQueue {
 public:
  explicit BoundedThreads(unsigned count) : most_(count), pool_(count) {}

  void enqueue(std::function<void()> serve) override {
    if (busy_ >= most_) {
      refuse_connection = true;
      serve();
      refuse_connection = false;
      return;
    }
    ++busy_;
    pool_.enqueue([this, serve = std::move(serve)] {
      serve();
      --busy_;
    });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  const unsigned most_;
  std::atomic<unsigned> busy_ = 0;
  httplib::ThreadPool pool_;
};

}  // namespace

class WorldServer::Impl final : public httplib::Server {
 public:
  Impl(ServedWorld world, const ServeOptions& options) : world_(std::move(world)), options_(options) {
    new_task_queue = [count = options_.connections] { return new BoundedThreads(count); };
    // The library would share the port with whoever has it, and take a part of the connections.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    set_default_headers({{"Access-Control-Allow-Origin", "*"},
                         {"Access-Control-Expose-Headers", "ETag, Content-Range, Content-Length, Accept-Ranges"},
                         {"X-Content-Type-Options", "nosniff"}});
    set_pre_routing_handler([this](const Request& request, Response& response) {
      answer(request, response);
      return HandlerResponse::Handled;
    });
    set_logger([](const Request&, const Response& response) { last_status_ = response.status; });
    set_keep_alive_timeout(options_.times.idle_ms / 1000);  // as clients are told
    set_keep_alive_max_count(100'000);
  }

  Status listen() {
    // IPv6 addresses are written in brackets in URLs.
    std::string address = options_.address;
    if (address.starts_with('[') && address.ends_with(']')) address = address.substr(1, address.size() - 2);
    errno = 0;  // an address that no name server knows sets none
    const bool bound =
        options_.port == 0 ? (port_ = bind_to_any_port(address)) > 0 : bind_to_port(address, port_ = options_.port);
    if (!bound)
      return Error{ErrorCode::kIo,
                   "cannot listen there: " + std::string(errno != 0 ? std::strerror(errno) : "no such address"),
                   options_.address + ":" + std::to_string(options_.port)};
    ::listen(svr_sock_, kBacklog);
    return {};
  }

  [[nodiscard]] int port() const { return port_; }

  void run() {
    std::thread ending([this] {
      state_.wait(ServerState::kServing);
      const auto until = Clock::now() + kLastRequests;
      while (metrics_.in_flight() > 0 && Clock::now() < until)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      while (!is_running() && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      state_ = ServerState::kEnded;
      httplib::Server::stop();
    });
    listen_after_bind();
    ended_ = true;
    stop();
    ending.join();
  }

  void stop() {
    ServerState serving = ServerState::kServing;
    state_.compare_exchange_strong(serving, ServerState::kStopping);
    state_.notify_all();
  }

 private:
  void answer(const Request& request, Response& response) const {
    if (request.method == "OPTIONS") {
      response.status = 200;  // the library gives 204 a Content-Length, which it must not have
      response.set_header("Allow", "GET, HEAD, OPTIONS");
      response.set_header("Access-Control-Allow-Methods", "GET, HEAD, OPTIONS");
      response.set_header("Access-Control-Allow-Headers", "Range, If-Range, If-None-Match");
      response.set_header("Access-Control-Max-Age", "86400");
      return;
    }
    if (request.method != "GET" && request.method != "HEAD") {
      response.set_header("Allow", "GET, HEAD, OPTIONS");
      return set_text(response, 405, "only GET, HEAD and OPTIONS\n");
    }
    if (request.path == "/metrics")
      return set_text(response, 200, metrics_.prometheus(), "text/plain; version=0.0.4; charset=utf-8");
    if (request.path == "/healthz") {
      const bool there = world_.find(world_.first_name()).has_value();
      return set_text(response, there ? 200 : 503, there ? "ok\n" : "the world is not there\n");
    }
    std::string_view name = request.path;
    while (name.starts_with('/')) name.remove_prefix(1);  // viewers write two where a tileset lies at the top
    std::optional<ServedFile> file = world_.find(name);
    if (!file) return set_text(response, 404, "the world has no such file\n");
    answer_file(request, response, *std::move(file));
  }

  // In place of the library's: see client_connection.h.
  bool process_and_close_socket(socket_t socket) override {
    ClientConnection connection(socket, options_.times, state_);
    if (refuse_connection || state_ != ServerState::kServing) {
      metrics_.refuse_connection();
      connection.refuse("503 Service Unavailable\r\nRetry-After: 1");
      return false;
    }
    metrics_.open_connection();
    while (serve_one(connection)) {
    }
    metrics_.close_connection();
    return true;
  }

  bool serve_one(ClientConnection& connection) {
    const ClientConnection::Next next = connection.next();
    if (next == ClientConnection::Next::kEnd) return false;
    const auto began = Clock::now();
    const std::uint64_t before = connection.written_bytes();
    const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
    metrics_.begin_request();
    if (next != ClientConnection::Next::kRequest) {
      const auto [status, line] = refusal_of(next);
      connection.refuse(line);
      metrics_.end_request(status, 0, seconds());
      return false;
    }
    last_status_ = 0;  // nothing was sent
    bool closed = false;
    const bool last = connection.has_body() || state_ != ServerState::kServing;
    const bool sent = process_request(connection, last, closed, nullptr);
    metrics_.end_request(last_status_, connection.written_bytes() - before, seconds());
    const bool lost = last_status_ == 400 || last_status_ == 414;  // where one request ends and the next begins
    return sent && !closed && !last && !lost;
  }

  const ServedWorld world_;
  const ServeOptions options_;
  ServeMetrics metrics_;
  int port_ = 0;
  std::atomic<ServerState> state_ = ServerState::kServing;
  std::atomic<bool> ended_ = false;
  static thread_local int last_status_;  // of the answer that this thread sent
};

thread_local int WorldServer::Impl::last_status_ = 0;

Result<std::unique_ptr<WorldServer>> WorldServer::listen(ServedWorld world, const ServeOptions& options) {
  auto impl = std::make_unique<Impl>(std::move(world), options);
  ZC_TRY(impl->listen());
  return std::unique_ptr<WorldServer>(new WorldServer(std::move(impl)));
}

WorldServer::WorldServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WorldServer::~WorldServer() = default;
int WorldServer::port() const { return impl_->port(); }
void WorldServer::run() { impl_->run(); }
void WorldServer::stop() { impl_->stop(); }

}  // namespace zc
