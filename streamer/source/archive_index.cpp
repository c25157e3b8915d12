// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/archive_index.h"

#include <md5.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace zc {
namespace {

// PKWARE's APPNOTE, 4.3.7 and 4.3.12.
constexpr std::uint32_t kLocalHeaderMagic = 0x04034B50;
constexpr std::size_t kCentralHeaderBytes = 46;
constexpr std::uint32_t kCentralHeaderMagic = 0x02014B50;
constexpr std::uint64_t kIn64 = 0xFFFFFFFF;  // the number does not fit and stands elsewhere
constexpr std::uint16_t kFlagEncrypted = 1;
constexpr std::uint16_t kFlagSizesBehind = 8;

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// The offset of a file beyond 4 GiB, in its entry's field for such numbers (APPNOTE 4.5.3), which alone has it here:
// the index itself is smaller.
Result<std::uint64_t> wide_offset(std::span<const std::byte> extra) {
  constexpr std::uint16_t kWideField = 1;
  if (extra.size() < 12 || number_at<std::uint16_t>(extra, 0) != kWideField || number_at<std::uint16_t>(extra, 2) < 8)
    return Error{ErrorCode::kFormat, "its place in the archive is missing"};
  return number_at<std::uint64_t>(extra, 4);
}

}  // namespace

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

Result<std::uint64_t> find_archive_index(std::span<const std::byte> tail) {
  const std::string_view name = kArchiveIndexName;
  for (std::size_t at = tail.size() - std::min(tail.size(), kCentralHeaderBytes + name.size()) + 1; at-- > 0;) {
    const std::span<const std::byte> entry = tail.subspan(at);
    if (entry.size() < kCentralHeaderBytes + name.size() || number_at<std::uint32_t>(entry, 0) != kCentralHeaderMagic)
      continue;
    if (number_at<std::uint16_t>(entry, 28) != name.size() ||
        std::memcmp(entry.data() + kCentralHeaderBytes, name.data(), name.size()) != 0)
      break;  // another file is the last
    const std::uint64_t header_at = number_at<std::uint32_t>(entry, 42);
    if (header_at == kIn64) return wide_offset(entry.subspan(kCentralHeaderBytes + name.size()));
    return header_at;
  }
  return Error{ErrorCode::kFormat, "has no index as its last file: not a 3D Tiles archive"};
}

Result<LocalHeader> read_local_header(std::span<const std::byte> front) {
  if (front.size() < kLocalHeaderBytes || number_at<std::uint32_t>(front, 0) != kLocalHeaderMagic)
    return Error{ErrorCode::kFormat, "the archive's index does not lead to a file"};
  const std::uint64_t name_bytes = number_at<std::uint16_t>(front, 26);
  if (name_bytes > front.size() - kLocalHeaderBytes) return Error{ErrorCode::kFormat, "its header is cut"};
  LocalHeader header;
  header.name = {reinterpret_cast<const char*>(front.data()) + kLocalHeaderBytes, name_bytes};
  const auto flags = number_at<std::uint16_t>(front, 6);
  const auto method = number_at<std::uint16_t>(front, 8);
  header.bytes = number_at<std::uint32_t>(front, 18);
  if (method != 0 || (flags & (kFlagEncrypted | kFlagSizesBehind)) != 0 || header.bytes == kIn64)
    return Error{ErrorCode::kUnsupported, "is not stored as it is in the archive"};
  header.data_at = kLocalHeaderBytes + name_bytes + number_at<std::uint16_t>(front, 28);
  return header;
}

}  // namespace zc
