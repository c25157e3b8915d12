// SPDX-License-Identifier: GPL-3.0-or-later
// The files of one tileset: read from wherever they lie, unpacked where they are gzipped. Those that are not there are
// counted, or end the import.
// Borrows: where they are read from. Untrusted input. Not thread-safe.
#pragma once

#include <optional>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"

namespace zc {

// Of what a file unpacks to: a few bytes may unpack to any number.
inline constexpr std::uint64_t kMaxUnpackedBytes = std::uint64_t{1} << 28U;

class TileFiles {
 public:
  TileFiles(const InputFiles& from, bool skip_missing) : from_(from), skip_missing_(skip_missing) {}

  // Nothing when the file is not there and may be skipped.
  Result<std::optional<std::vector<std::byte>>> read(const std::filesystem::path& file, std::uint64_t limit_bytes);
  // What became of the import of a file: one that is not there may be skipped, or the error says how.
  Status settle(Status status);
  void report(SceneBuilder& builder) const;
  [[nodiscard]] const InputFiles& from() const { return from_; }

 private:
  const InputFiles& from_;
  bool skip_missing_;
  std::uint64_t missing_ = 0;
  std::vector<std::string> first_missing_;
};

}  // namespace zc
