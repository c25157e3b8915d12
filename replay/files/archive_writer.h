// SPDX-License-Identifier: Apache-2.0
// Writes a 3D Tiles archive (streamer/archive_index.h): files as they are, in the order given, then the index. The same
// files give the same bytes. Whole or not there: written beside its place under another name, then renamed.
// Threads: one. Fails when the disk does.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "streamer/source/archive_index.h"

namespace zc {

class ArchiveWriter {
 public:
  // A file that is there is replaced; anything else that is there is not.
  static Result<ArchiveWriter> create(const std::filesystem::path& path);
  ArchiveWriter(ArchiveWriter&&) noexcept;
  ArchiveWriter& operator=(ArchiveWriter&&) = delete;
  ~ArchiveWriter();

  Status add(const std::string& name, std::span<const std::byte> bytes);
  // Adds the index and puts the archive in its place.
  Status commit();

 private:
  struct Zip;
  explicit ArchiveWriter(std::unique_ptr<Zip> zip);
  Status store(const std::string& name, std::span<const std::byte> bytes);

  std::unique_ptr<Zip> zip_;
  std::vector<ArchiveEntry> entries_;
};

}  // namespace zc
