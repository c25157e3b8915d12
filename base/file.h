// SPDX-License-Identifier: Apache-2.0
// Reads, of whole files or piece by piece, and all-or-nothing writes. Untrusted input: sizes are checked before memory
// is taken. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace zc {

// A file that is open for reading. Threads: any, at once.
class InputFile {
 public:
  // Fails when it is missing, not a regular file, or larger than limit_bytes.
  static Result<InputFile> open(const std::filesystem::path& path, std::uint64_t limit_bytes = UINT64_MAX);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  ~InputFile();

  // When it was opened.
  [[nodiscard]] std::uint64_t size_bytes() const { return size_bytes_; }
  // [offset_bytes, offset_bytes + out.size()) of the file. Fails on a short read.
  Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const;

 private:
  InputFile(int handle, std::string path) : handle_(handle), path_(std::move(path)) {}

  int handle_;
  std::uint64_t size_bytes_ = 0;
  std::string path_;  // for errors
};

// Size in bytes of a regular file. Fails when it is missing or not a regular file.
Result<std::uint64_t> file_size_bytes(const std::filesystem::path& path);

// The whole file. Fails when it is missing, unreadable, or larger than limit_bytes.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t limit_bytes);

// [offset_bytes, offset_bytes + out.size()) of the file. Fails on a short read.
Status read_range(const std::filesystem::path& path, std::uint64_t offset_bytes, std::span<std::byte> out);

// Writes beside `path` under a temporary name, closes, renames: the file is whole or as it was, whatever kills the
// process. Nothing is forced to the disk: a power cut may still undo it. What a link leads to is replaced, not the
// link; pipes and devices are written to as they are.
Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
// The same of several parts, one after the other.
Status write_file_parts(const std::filesystem::path& path, std::span<const std::span<const std::byte>> parts);

// With the folders above it; one that is there already will do.
Status make_folder(const std::filesystem::path& folder);

}  // namespace zc
