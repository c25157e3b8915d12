// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/retry_policy.h"

#include <algorithm>
#include <utility>

#include "streamer/source/retry.h"

namespace zc {
namespace {

constexpr double kRetryAfterLimit_s = 3600;

bool may_pass(CURLcode code) {
  switch (code) {
    case CURLE_UNSUPPORTED_PROTOCOL:
    case CURLE_URL_MALFORMAT:
    case CURLE_TOO_MANY_REDIRECTS:
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
    case CURLE_SSL_CERTPROBLEM:
    case CURLE_WEIRD_SERVER_REPLY:
      return false;
    default:
      return true;
  }
}

}  // namespace

Error transient_failure(const HttpRequest& request, std::string message) {
  return {ErrorCode::kTransient, std::move(message), request.name};
}

Error lasting_failure(const HttpRequest& request, std::string message) {
  Error error{ErrorCode::kIo, std::move(message), request.name};
  error.retry_after_s = kLongestRetryDelay_s;
  return error;
}

std::optional<Error> status_failure(const HttpRequest& request, long status, std::optional<double> retry_after_s) {
  if (status == 200 || status == 206 || status == 304) return std::nullopt;
  const std::string message = "the server answers with status " + std::to_string(status);
  const bool later = status == 408 || status == 425 || status == 429 || status >= 500;
  if (!later) {
    Error error = lasting_failure(request, message);
    if (status == 404 || status == 410) error.code = ErrorCode::kMissing;
    return error;
  }
  Error error = transient_failure(request, message);
  if (retry_after_s) error.retry_after_s = std::clamp(*retry_after_s, 0.0, kRetryAfterLimit_s);
  return error;
}

Error transfer_failure(const HttpRequest& request, CURLcode code, std::string message) {
  if (message.empty()) message = curl_easy_strerror(code);
  return may_pass(code) ? transient_failure(request, std::move(message)) : lasting_failure(request, std::move(message));
}

}  // namespace zc
