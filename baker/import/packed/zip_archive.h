// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a ZIP archive, read from it one by one; none is written to the disk. A file is called by the archive's
// path and its own behind it. Source: PKWARE APPNOTE 6.3.10, through minizip.
// Owns the open archive. Untrusted input: sizes are checked before memory is taken, of one file and of all that are
// read. Not thread-safe.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "base/result.h"

namespace zc {

class ZipArchive final : public InputFiles {
 public:
  static Result<std::unique_ptr<ZipArchive>> open(const std::filesystem::path& archive);
  ~ZipArchive() override;

  // Of all files, in order.
  [[nodiscard]] std::vector<std::string> names() const;
  // Fails, beside what InputFiles says, on files that are encrypted or packed by another method than deflate.
  [[nodiscard]] Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                    std::uint64_t limit_bytes) const override;

 private:
  struct Entry {
    std::uint64_t place = 0;  // as minizip finds it again
    std::uint64_t number = 0;
    std::uint64_t packed_bytes = 0;
    std::uint64_t bytes = 0;
    bool encrypted = false;
    bool known_method = false;
  };

  ZipArchive(std::filesystem::path archive, void* handle) : archive_(std::move(archive)), handle_(handle) {}
  Status list();
  [[nodiscard]] Error error(const std::string& message, const std::filesystem::path& file) const;

  std::filesystem::path archive_;
  void* handle_;                          // unzFile
  std::uint64_t packed_bytes_ = 0;        // of the archive
  mutable std::uint64_t unpacked_ = 0;    // of all that was read
  std::map<std::string, Entry> entries_;  // of two with a name, the first
};

}  // namespace zc
