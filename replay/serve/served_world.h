// SPDX-License-Identifier: Apache-2.0
// The files that a served world consists of, by the names that may be asked for: those of a world's folder, or the one
// archive. Threads: any. Untrusted input: only names of that form are looked for at all; what is there is opened when
// it is asked for, and stays the same file while it is sent, whatever happens to its name. Links in a world are not
// followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace zc {

class ServedFile {
 public:
  ServedFile(ServedFile&& other) noexcept;
  ServedFile& operator=(ServedFile&&) = delete;
  ~ServedFile();

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  // Strong: another file, or the same one written again, has another.
  [[nodiscard]] const std::string& etag() const { return etag_; }
  [[nodiscard]] const char* type() const { return type_; }
  // How many were read; fewer than asked for when the file became shorter or the disk fails.
  std::size_t read(std::uint64_t offset, std::span<char> out) const;

 private:
  friend class ServedWorld;
  ServedFile(int handle, std::uint64_t bytes, std::string etag, const char* type)
      : handle_(handle), bytes_(bytes), etag_(std::move(etag)), type_(type) {}
  int handle_;
  std::uint64_t bytes_;
  std::string etag_;
  const char* type_;
};

class ServedWorld {
 public:
  // Fails when there is no world.
  static Result<ServedWorld> open(const std::filesystem::path& place);

  // Nothing when the world has no such file.
  [[nodiscard]] std::optional<ServedFile> find(std::string_view name) const;
  // The file without which there is no world.
  [[nodiscard]] const std::string& first_name() const { return first_name_; }
  // What stands behind the server's address: nothing for a folder, the archive's name.
  [[nodiscard]] std::string address_end() const { return folder_ ? std::string() : first_name_; }

 private:
  ServedWorld(std::filesystem::path place, bool folder, std::string first_name)
      : place_(std::move(place)), folder_(folder), first_name_(std::move(first_name)) {}
  std::filesystem::path place_;
  bool folder_;
  std::string first_name_;
};

// Whether a world's folder can have a file of this name that others may read.
[[nodiscard]] bool names_world_file(std::string_view name);

}  // namespace zc
