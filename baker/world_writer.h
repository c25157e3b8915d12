// SPDX-License-Identifier: GPL-3.0-or-later
// Writes a world all or nothing: files go to a temporary sibling directory that takes the final name when complete.
// Owns the temporary directory and removes it unless committed. Not thread-safe, except write().
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace zc {

class WorldWriter {
 public:
  // Fails when `out` exists and is neither a world nor an empty directory.
  static Result<WorldWriter> open(const std::filesystem::path& out);

  WorldWriter(WorldWriter&& other) noexcept;
  WorldWriter& operator=(WorldWriter&&) = delete;
  WorldWriter(const WorldWriter&) = delete;
  WorldWriter& operator=(const WorldWriter&) = delete;
  ~WorldWriter();

  Status make_directory(const std::string& relative);
  // Different files from different threads.
  Status write(const std::string& relative, std::span<const std::byte> bytes) const;
  Status write_text(const std::string& relative, std::string_view text) const;

  // The world takes its name; what was there before goes.
  Status commit();

 private:
  WorldWriter(std::filesystem::path out, std::filesystem::path temporary);

  std::filesystem::path out_;
  std::filesystem::path temporary_;  // empty once committed or moved from
};

}  // namespace zc
