// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/transfer.h"

#include <cstdlib>
#include <exception>
#include <span>
#include <string_view>
#include <utility>

#include "base/check.h"
#include "streamer/source/http/retry_policy.h"

namespace zc {
namespace {

constexpr long kMostRedirects = 4;
constexpr std::uint64_t kErrorBodyLimitBytes = 16 << 10U;  // read and dropped, so that the connection can be used again
constexpr std::uint64_t kLeastBytes = 1024;                // between two checks; less is a stall

std::string range_header(const HttpRequest& request) {
  if (request.last_bytes > 0) return "-" + std::to_string(request.last_bytes);
  ZC_CHECK(request.range->bytes > 0);
  return std::to_string(request.range->first) + "-" + std::to_string(request.range->first + request.range->bytes - 1);
}

}  // namespace

bool Transfer::open(double timeout_s) {
  handle_ = curl_easy_init();
  if (handle_ == nullptr) return false;
  const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(handle_, option, value); };
  const bool secure = request_.url.starts_with("https:");
  set(CURLOPT_URL, request_.url.c_str());
  set(CURLOPT_PRIVATE, static_cast<void*>(this));
  set(CURLOPT_ERRORBUFFER, curl_message_.data());
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_USERAGENT, "zonecast");
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_REDIR_PROTOCOLS_STR, secure ? "https" : "http,https");
  set(CURLOPT_FOLLOWLOCATION, 1L);
  set(CURLOPT_MAXREDIRS, kMostRedirects);
  set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_2TLS));
  set(CURLOPT_PIPEWAIT, secure ? 1L : 0L);  // rather one connection of HTTP/2 than many
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(1e3 * timeout_s));
  set(CURLOPT_HEADERFUNCTION, &Transfer::on_header);
  set(CURLOPT_HEADERDATA, static_cast<void*>(this));
  set(CURLOPT_WRITEFUNCTION, &Transfer::on_body);
  set(CURLOPT_WRITEDATA, static_cast<void*>(this));
  // Where the curl command looks for the certificates of an organisation's own authority.
  if (const char* bundle = std::getenv("CURL_CA_BUNDLE"); bundle != nullptr && *bundle != '\0')
    set(CURLOPT_CAINFO, bundle);
  if (request_.head) set(CURLOPT_NOBODY, 1L);
  if (request_.ranged()) set(CURLOPT_RANGE, range_header(request_).c_str());
  add_header("Accept-Encoding: identity");
  if (!request_.if_range.empty()) add_header("If-Range: " + request_.if_range);
  if (!request_.if_none_match.empty()) add_header("If-None-Match: " + request_.if_none_match);
  set(CURLOPT_HTTPHEADER, headers_);
  window_at_ = Clock::now();
  return true;
}

void Transfer::add_header(const std::string& line) {
  if (curl_slist* longer = curl_slist_append(headers_, line.c_str()); longer != nullptr) headers_ = longer;
}

void Transfer::close() {
  if (handle_ != nullptr) curl_easy_cleanup(std::exchange(handle_, nullptr));
  if (headers_ != nullptr) curl_slist_free_all(std::exchange(headers_, nullptr));
}

long Transfer::status() const {
  long value = 0;
  curl_easy_getinfo(handle_, CURLINFO_RESPONSE_CODE, &value);
  return value;
}

std::optional<Error> Transfer::status_failure() const {
  curl_off_t after_s = 0;
  const bool asked = curl_easy_getinfo(handle_, CURLINFO_RETRY_AFTER, &after_s) == CURLE_OK;
  return zc::status_failure(request_, status(), asked ? std::optional(static_cast<double>(after_s)) : std::nullopt);
}

// Both return another number than they got to end the transfer.
std::size_t Transfer::on_header(char* data, std::size_t, std::size_t bytes, void* self) {
  auto& transfer = *static_cast<Transfer*>(self);
  return transfer.guarded(bytes, [&] {
    transfer.fault_ = transfer.response_->add_header({data, bytes}, transfer.status());
    return !transfer.fault_;
  });
}

std::size_t Transfer::on_body(char* data, std::size_t, std::size_t bytes, void* self) {
  auto& transfer = *static_cast<Transfer*>(self);
  return transfer.guarded(bytes, [&] {
    transfer.body_bytes_ += bytes;
    if (transfer.status_failure()) return transfer.body_bytes_ <= kErrorBodyLimitBytes;
    transfer.fault_ = transfer.response_->add_body(std::as_bytes(std::span(data, bytes)));
    return !transfer.fault_;
  });
}

// No exception may pass through C.
template <class F>
std::size_t Transfer::guarded(std::size_t bytes, F&& accept) {
  const std::size_t refused = bytes == 0 ? 1 : 0;
  window_bytes_ += bytes;
  try {
    return accept() ? bytes : refused;
  } catch (const std::exception& exception) {
    fault_ = failure(exception.what());
    return refused;
  }
}

bool Transfer::stalled(double timeout_s) {
  if (Clock::now() - window_at_ < std::chrono::duration<double>(timeout_s)) return false;
  if (window_bytes_ < kLeastBytes) return true;
  window_at_ = Clock::now();
  window_bytes_ = 0;
  return false;
}

Result<HttpAnswer> Transfer::conclude(CURLcode code) {
  if (fault_) return *std::move(fault_);
  const bool reached = code == CURLE_OK || code == CURLE_WRITE_ERROR;  // ours, at a long body of an error
  if (reached)
    if (std::optional<Error> refused = status_failure()) return *std::move(refused);
  if (code != CURLE_OK) return transfer_failure(request_, code, curl_message_.data());
  return response_->finish(status());
}

Error Transfer::failure(std::string message) const { return transient_failure(request_, std::move(message)); }

void Transfer::publish(Result<HttpAnswer> outcome) {
  response_.reset();
  const std::lock_guard lock(mutex_);
  outcome_ = std::move(outcome);
  done_.notify_all();
}

Result<HttpAnswer>& Transfer::wait() {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return outcome_.has_value(); });
  return *outcome_;
}

}  // namespace zc
