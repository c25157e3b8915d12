// SPDX-License-Identifier: Apache-2.0
// The index of a 3D Tiles archive (.3tz, version 1.3 of its specification): a ZIP of stored files whose last one lists
// where each lies, sorted by the MD5 of its name, so that a file is found without the ZIP's own directory.
// Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/result.h"

namespace zc {

inline constexpr const char* kArchiveIndexName = "@3dtilesIndex1@";
inline constexpr std::size_t kArchiveEntryBytes = 24;

// The MD5 of a name as two little-endian numbers, low first: compares as entries are sorted.
using ArchiveKey = std::array<std::uint64_t, 2>;
ArchiveKey archive_key(std::string_view name);

struct ArchiveEntry {
  ArchiveKey key = {};
  std::uint64_t offset = 0;  // of the file's local header, in bytes from the archive's start
};
static_assert(sizeof(ArchiveEntry) == kArchiveEntryBytes);

// Where the local header of the index is, from the archive's last bytes: the index is its last file, so that its entry
// in the ZIP's directory is the last too. Fails when it is not there. Untrusted input.
inline constexpr std::size_t kArchiveTailBytes = 1024;
Result<std::uint64_t> find_archive_index(std::span<const std::byte> tail);

// What stands before a file. `name` lies in the bytes it was read from.
inline constexpr std::size_t kLocalHeaderBytes = 30;  // without the name
struct LocalHeader {
  std::string_view name;
  std::uint64_t data_at = 0;  // bytes behind the header's first
  std::uint64_t bytes = 0;
};

// From the bytes at an entry's offset, as many as the header and the name take or more. Fails when that is no header,
// or that of a file that is not stored as it is. Untrusted input.
Result<LocalHeader> read_local_header(std::span<const std::byte> front);

}  // namespace zc
