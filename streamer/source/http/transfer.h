// SPDX-License-Identifier: Apache-2.0
// One request on its way through libcurl: its handle, what has come of the answer, and the outcome that callers wait
// for.
// Owns: the handle and the answer. Threads: the client's thread alone until the outcome is published; wait(), cancel()
// and cancelled() from any. Units: bytes, seconds. Untrusted input: what comes is checked by ResponseRules.
// Fails when: the connection does, the server stalls, or the answer breaks a rule; retry_policy.h says which may pass.
#pragma once

#include <curl/curl.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "streamer/source/http/request.h"
#include "streamer/source/http/response_rules.h"

namespace zc {

class Transfer {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Transfer(HttpRequest request) : request_(std::move(request)), response_(std::in_place, request_) {}
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;
  ~Transfer() { close(); }

  // --- the client's thread ---

  // Makes the handle, whose CURLINFO_PRIVATE is this. False when there is no memory. timeout_s: to connect.
  [[nodiscard]] bool open(double timeout_s);
  void close();
  [[nodiscard]] CURL* handle() const { return handle_; }

  // Whether less than 1 KiB has come in the timeout_s since the last check; sooner there is nothing to say.
  [[nodiscard]] bool stalled(double timeout_s);
  [[nodiscard]] Clock::time_point last_check() const { return window_at_; }
  [[nodiscard]] std::uint64_t body_bytes() const { return body_bytes_; }

  // The outcome of a transfer that libcurl has ended.
  [[nodiscard]] Result<HttpAnswer> conclude(CURLcode code);
  [[nodiscard]] Error failure(std::string message) const;
  // Hands the outcome to whoever waits; what is left of the answer goes.
  void publish(Result<HttpAnswer> outcome);

  // --- any thread ---

  [[nodiscard]] Result<HttpAnswer>& wait();
  void cancel() { cancelled_ = true; }
  [[nodiscard]] bool cancelled() const { return cancelled_; }

 private:
  void add_header(const std::string& line);
  [[nodiscard]] long status() const;
  [[nodiscard]] std::optional<Error> status_failure() const;
  static std::size_t on_header(char* data, std::size_t, std::size_t bytes, void* self);
  static std::size_t on_body(char* data, std::size_t, std::size_t bytes, void* self);
  template <class F>
  std::size_t guarded(std::size_t bytes, F&& accept);

  const HttpRequest request_;
  CURL* handle_ = nullptr;
  curl_slist* headers_ = nullptr;
  std::array<char, CURL_ERROR_SIZE> curl_message_ = {};
  std::optional<ResponseRules> response_;
  std::optional<Error> fault_;  // why a callback ended the transfer
  std::uint64_t body_bytes_ = 0;
  Clock::time_point window_at_;
  std::uint64_t window_bytes_ = 0;  // since then

  std::atomic<bool> cancelled_ = false;
  std::mutex mutex_;
  std::condition_variable done_;
  std::optional<Result<HttpAnswer>> outcome_;
};

}  // namespace zc
