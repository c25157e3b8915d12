// SPDX-License-Identifier: Apache-2.0
// Which answers a request accepts: the headers line by line, then the body part by part, then the whole. After an error
// the transfer ends.
// Owns: the answer. Borrows: the request. Units: bytes. Threads: one at a time.
// Untrusted input: headers, their values and the body are bounded; memory for a body is taken up to 64 MiB because a
// server announces it, beyond that as it comes.
// Fails when: the body is encoded, longer than the request allows or not as long as announced; a range is another one
// than asked for, or the whole file; a range is of another version than if_range names (lasting); 304 comes unasked.
// Source: RFC 9110 (ranges, conditional requests).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "streamer/source/http/request.h"

namespace zc {

// Whether the ETag says that equal bytes come with it, and not only something that is as good.
[[nodiscard]] bool strong_etag(std::string_view etag);

class ResponseRules {
 public:
  explicit ResponseRules(const HttpRequest& request) : request_(request) {}
  explicit ResponseRules(HttpRequest&&) = delete;  // it is borrowed

  // The next line of the headers; the empty one ends them. A status line begins another answer: after a redirection, or
  // after an interim answer. `status`: of the answer that the line is of.
  [[nodiscard]] std::optional<Error> add_header(std::string_view line, long status);
  // The next part of the body of an answer with status 200 or 206.
  [[nodiscard]] std::optional<Error> add_body(std::span<const std::byte> part);
  // Of an answer that came to its end.
  [[nodiscard]] Result<HttpAnswer> finish(long status);

 private:
  struct ContentRange {
    std::uint64_t first = 0, last = 0;
    std::uint64_t file_bytes = 0;  // 0: not given
  };
  static std::optional<ContentRange> parse_content_range(std::string_view text);
  void take_header(std::string_view line);
  [[nodiscard]] std::optional<Error> check_headers(long status);
  [[nodiscard]] bool fits(const ContentRange& got) const;
  [[nodiscard]] Error too_long() const;

  const HttpRequest& request_;
  HttpAnswer answer_;
  std::string content_range_, encoding_;
  std::optional<std::uint64_t> announced_;  // Content-Length
  std::optional<std::uint64_t> expected_;   // what the body must have
  std::uint64_t header_bytes_ = 0;
};

}  // namespace zc
