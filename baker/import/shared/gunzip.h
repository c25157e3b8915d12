// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes that were compressed with gzip or deflate (zlib reads them), up to a limit. Untrusted input. Thread-safe: no
// state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

// Whether these are the first bytes of a gzip file.
[[nodiscard]] bool is_gzip(std::span<const std::byte> bytes);
// The same of a ZIP archive, whose members are inflated one by one.
[[nodiscard]] bool is_zip(std::span<const std::byte> bytes);

// All members of a gzip file one after the other. Memory is taken as bytes come. Fails when the file is damaged or ends
// early; with kUnsupported when it unpacks to more than limit_bytes, and at that to more than `ratio` times the bytes
// that were read so far. `path` is for errors.
Result<std::vector<std::byte>> gunzip(std::span<const std::byte> bytes, const std::string& path,
                                      std::uint64_t limit_bytes, std::uint64_t ratio = 0);

// A deflate stream without a header, of which the caller knows how long it becomes.
Result<std::vector<std::byte>> inflate_raw(std::span<const std::byte> bytes, const std::string& path,
                                           std::uint64_t out_bytes);

}  // namespace zc
