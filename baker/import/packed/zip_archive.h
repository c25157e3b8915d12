// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a ZIP archive, read from it one by one: stored, deflated or compressed with Zstandard; none is written
// to the disk. A file is called by the archive's path and its own behind it: in a.3tz the file tileset.json is
// a.3tz/tileset.json. minizip reads the directory of the archive. Source: PKWARE APPNOTE 6.3.10.
// Owns the open archive. Untrusted input: sizes are checked before memory is taken, of one file and of all that are
// read. Not thread-safe.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "base/file.h"
#include "base/result.h"

namespace zc {

class ZipArchive final : public InputFiles {
 public:
  static Result<std::unique_ptr<ZipArchive>> open(const std::filesystem::path& archive);

  // Of all files, in order.
  [[nodiscard]] std::vector<std::string> names() const;
  // Fails, beside what InputFiles says, on files that are encrypted or packed by another method.
  [[nodiscard]] Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                    std::uint64_t limit_bytes) const override;

 private:
  struct Entry {
    std::uint64_t place = 0;  // in the directory of the archive
    std::uint64_t packed_bytes = 0;
    std::uint64_t bytes = 0;
    unsigned long method = 0;
    unsigned long checksum = 0;
    bool encrypted = false;
    mutable bool counted = false;  // in unpacked_
  };

  ZipArchive(std::filesystem::path archive, InputFile file) : archive_(std::move(archive)), file_(std::move(file)) {}
  Status list(void* handle);
  [[nodiscard]] Result<std::vector<std::byte>> packed(const Entry& entry, const std::filesystem::path& file) const;
  [[nodiscard]] Result<std::uint64_t> local_header(const Entry& entry, const std::filesystem::path& file) const;

  std::filesystem::path archive_;
  InputFile file_;
  mutable std::uint64_t unpacked_ = 0;    // of all files that were read
  std::map<std::string, Entry> entries_;  // of two with a name, the first
};

}  // namespace zc
