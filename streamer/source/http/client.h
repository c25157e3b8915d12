// SPDX-License-Identifier: Apache-2.0
// Fetches over HTTP and HTTPS, several at once: connections are kept and shared, HTTP/2 is taken where TLS offers it.
// Owns: one thread, which does all the network's work · threads: every method of HttpClient from any; a Download's
// wait() from one, its cancel() from any · units: bytes, seconds · untrusted input: redirects are bounded, and so is
// everything that response_rules.h counts · fails when: as retry_policy.h says, kTransient or kIo; kFormat where a
// server sends more than the request allows.
#pragma once

#include <cstdint>
#include <memory>

#include "base/result.h"
#include "streamer/source/http/request.h"

namespace zc {

struct HttpCounts {
  std::uint64_t requests = 0;        // sent, or tried to
  std::uint64_t failed = 0;          // of them, those cancelled not counted
  std::uint64_t bytes_received = 0;  // of bodies, of the failed too
  std::uint64_t not_modified = 0;    // 304
};

class Transfer;

class HttpClient {
  class Impl;

 public:
  // A fetch on its way; cancelled, and its memory freed, when it goes.
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
    Download(Impl& client, std::shared_ptr<Transfer> transfer) : client_(&client), transfer_(std::move(transfer)) {}
    Impl* client_;
    std::shared_ptr<Transfer> transfer_;
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
  explicit HttpClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace zc
