// SPDX-License-Identifier: Apache-2.0
#include "streamer/archive_index.h"

#include <md5.h>

#include <bit>
#include <cstring>

namespace zc {

static_assert(std::endian::native == std::endian::little, "entries are read in place");

ArchiveKey archive_key(std::string_view name) {
  MD5_CTX context;
  MD5Init(&context);
  MD5Update(&context, reinterpret_cast<const std::uint8_t*>(name.data()), name.size());
  std::array<std::uint8_t, MD5_DIGEST_LENGTH> digest{};
  MD5Final(digest.data(), &context);
  ArchiveKey key;
  static_assert(sizeof key == sizeof digest);
  std::memcpy(key.data(), digest.data(), sizeof key);
  return key;
}

}  // namespace zc
