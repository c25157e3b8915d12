// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/packed/gzip_file.h"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <limits>

#include "baker/import/packed/unpack_limit.h"
#include "baker/import/shared/gunzip.h"

namespace zc {
namespace {

// Whether the members of a gzip file together unpack to more. Damage is left to who unpacks it.
bool unpacks_beyond(std::span<const std::byte> packed, std::uint64_t limit) {
  z_stream stream = {};
  constexpr int kGzipWindow = 15 + 16;
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) return true;
  std::array<Bytef, std::size_t{1} << 16U> sink;
  std::uint64_t unpacked = 0;
  for (int state = Z_OK; state == Z_OK && unpacked <= limit;) {
    const auto feed = static_cast<uInt>(std::min<std::size_t>(packed.size(), std::numeric_limits<uInt>::max()));
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data()));  // zlib does not write there
    stream.avail_in = feed;
    stream.next_out = sink.data();
    stream.avail_out = static_cast<uInt>(sink.size());
    state = inflate(&stream, Z_NO_FLUSH);
    packed = packed.subspan(feed - stream.avail_in);
    unpacked += sink.size() - stream.avail_out;
    if (state == Z_STREAM_END && is_gzip(packed)) state = inflateReset(&stream);
  }
  inflateEnd(&stream);
  return unpacked > limit;
}

}  // namespace

Result<std::vector<std::byte>> unpack_gzip(std::span<const std::byte> packed, const std::string& path) {
  const std::uint64_t limit = unpack_limit(packed.size());
  if (unpacks_beyond(packed, limit)) return unpacks_too_far(packed.size(), path);
  return gunzip(packed, path, limit);
}

}  // namespace zc
