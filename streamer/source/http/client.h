// SPDX-License-Identifier: Apache-2.0
// Fetches over HTTP and HTTPS, several at once: connections are kept and shared, HTTP/2 is taken where TLS offers it.
// Owns: one thread, which does all the network's work · threads: every method of HttpClient from any; a Download's
// wait() from one, its cancel() from any · units: bytes, seconds · untrusted input: headers, sizes and redirects are
// bounded, and a body never takes more memory than the request allows · fails when: kTransient where the same may work
// later (no connection, resets, stalls, short bodies, 408, 429, 5xx), with the server's Retry-After; kIo where it will
// not (404, bad certificates, ranges that are not served), to be asked again after the longest delay at the soonest.
// Sources: RFC 9110 (ranges, conditional requests, Retry-After).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

struct HttpRange {
  std::uint64_t first = 0;
  std::uint64_t bytes = 0;  // at least 1
};

struct HttpRequest {
  std::string url;
  std::string name;                // what errors call it
  bool head = false;               // no body
  std::optional<HttpRange> range;  // a server that knows how long the file is may send less, at its end
  std::uint64_t last_bytes = 0;    // instead of a range: so many at the file's end
  std::string if_range = {};       // a strong ETag: all of a range is of that version, or nothing comes
  std::string if_none_match = {};  // an ETag: status 304 when it still holds
  std::uint64_t limit_bytes = 0;   // most that the body may have; of a range, its length
};

struct HttpAnswer {
  int status = 0;                   // 200, 206 or 304
  std::string etag, last_modified;  // as sent; empty without
  std::uint64_t first_byte = 0;     // 206: of the body, in the file
  std::uint64_t file_bytes = 0;     // of the whole file, where the answer tells; 0: it does not
  std::vector<std::byte> body;
};

// Whether the ETag says that equal bytes come with it, and not only something that is as good.
[[nodiscard]] bool strong_etag(std::string_view etag);

// The URL as messages and keys may have it: without credentials and query.
[[nodiscard]] std::string public_url(const std::string& url);

// The URL of `name`, encoded, in the folder `url`; its query stays. Fails when `url` is none.
Result<std::string> url_below(const std::string& url, const std::string& name);

struct HttpCounts {
  std::uint64_t requests = 0;        // sent, or tried to
  std::uint64_t failed = 0;          // of them, those cancelled not counted
  std::uint64_t bytes_received = 0;  // of bodies, of the failed too
  std::uint64_t not_modified = 0;    // 304
};

class HttpClient {
 public:
  // A fetch on its way; given up, with its memory, when it goes.
  class Download {
   public:
    Download(Download&&) noexcept = default;
    Download& operator=(Download&&) = delete;
    ~Download();

    // Blocks until the answer is there; afterwards the same one.
    [[nodiscard]] const Result<HttpAnswer>& wait();
    // wait() returns at once, with an error if the answer had not come.
    void cancel();

   private:
    friend class HttpClient;
    struct State;
    explicit Download(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
  };

  // timeout_s: to connect, and for the silence after which a server counts as stalled.
  static Result<std::unique_ptr<HttpClient>> create(double timeout_s);
  ~HttpClient();  // after every Download
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  [[nodiscard]] Download start(HttpRequest request);
  Result<HttpAnswer> fetch(HttpRequest request);
  [[nodiscard]] HttpCounts counts() const;

 private:
  class Impl;
  explicit HttpClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace zc
