// SPDX-License-Identifier: Apache-2.0
// The index of a 3D Tiles archive (.3tz, version 1.3 of its specification): a ZIP of stored files whose last one lists
// where each lies, sorted by the MD5 of its name, so that a file is found without the ZIP's own directory.
// Thread-safe: no state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

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

}  // namespace zc
