// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/packed/gzip_file.h"

#include "baker/import/packed/unpack_limit.h"
#include "baker/import/shared/gunzip.h"

namespace zc {

Result<std::vector<std::byte>> unpack_gzip(std::span<const std::byte> packed, const std::string& path) {
  Result<std::vector<std::byte>> bytes = gunzip(packed, path, kAlwaysUnpackedBytes, kMaxUnpackRatio);
  if (!bytes.ok() && bytes.error().code == ErrorCode::kUnsupported) return unpacks_too_far(packed.size(), path);
  return bytes;
}

}  // namespace zc
