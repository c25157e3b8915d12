// SPDX-License-Identifier: Apache-2.0
// Which failures of a request may pass: those are kTransient, to be tried again after the usual delays
// (streamer/source/retry.h) or the server's Retry-After. All others are lasting: not before the longest delay.
//   transient: no connection, resets, stalls, short bodies; status 408, 425, 429, 500 and above
//   lasting:   every other status, redirects without end, bad certificates, answers that are not HTTP
// Units: seconds. Untrusted input: a Retry-After is bounded. Thread-safe: no state.
// Sources: RFC 9110 (status codes, Retry-After), RFC 6585 (429), RFC 8470 (425).
#pragma once

#include <curl/curl.h>

#include <optional>
#include <string>

#include "base/result.h"
#include "streamer/source/http/request.h"

namespace zc {

Error transient_failure(const HttpRequest& request, std::string message);
Error lasting_failure(const HttpRequest& request, std::string message);

// What a status means that is not 200, 206 or 304. `retry_after_s`: as the server asks, where it does.
std::optional<Error> status_failure(const HttpRequest& request, long status, std::optional<double> retry_after_s);

// `message`: libcurl's own words about this failure, where there are some.
Error transfer_failure(const HttpRequest& request, CURLcode code, std::string message);

}  // namespace zc
