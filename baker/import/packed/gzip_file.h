// SPDX-License-Identifier: GPL-3.0-or-later
// A model that was packed with gzip. Untrusted input: memory is taken as far as the bytes that were read allow.
// Thread-safe: no state.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

// Fails when the bytes are damaged, end early, or unpack to more than unpack_limit() of those that
// were read so far.
Result<std::vector<std::byte>> unpack_gzip(std::span<const std::byte> packed, const std::string& path);

}  // namespace zc
