// SPDX-License-Identifier: Apache-2.0
// What is asked of a server, and what it answers. Units: bytes. Thread-safe: plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  std::string if_none_match = {};  // an ETag: status 304 while it is the server's
  std::uint64_t limit_bytes = 0;   // most that the body may have; of a range, its length

  [[nodiscard]] bool ranged() const { return range || last_bytes > 0; }
};

struct HttpAnswer {
  int status = 0;                   // 200, 206 or 304
  std::string etag, last_modified;  // as sent; empty without
  std::uint64_t first_byte = 0;     // 206: of the body, in the file
  std::uint64_t file_bytes = 0;     // of the whole file, where the answer says; 0: it does not
  std::vector<std::byte> body;
};

}  // namespace zc
