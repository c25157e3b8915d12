// SPDX-License-Identifier: Apache-2.0
// Addresses of worlds on the web and of the files in them. Untrusted input. Thread-safe: no state.
#pragma once

#include <string>

#include "base/result.h"

namespace zc {

// The URL as messages and keys may have it: without credentials and query.
[[nodiscard]] std::string public_url(const std::string& url);

// The URL of `name`, encoded, in the folder `url`; its query stays. Fails when `url` is none.
Result<std::string> url_below(const std::string& url, const std::string& name);

}  // namespace zc
