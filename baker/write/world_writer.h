// SPDX-License-Identifier: GPL-3.0-or-later
// Writes a world all or nothing. Files go to a folder beside the world's, ".NAME.baking", and take its name when all of
// them are on the disk: whenever the process or the machine stops, `out` is the old world or the new one, whole. The
// two names are exchanged in one step where the file system can (renameat2, RENAME_EXCHANGE). Where it cannot, there is
// a moment without either between two renames; who stops in it leaves the old world in ".NAME.baking/old", and the next
// open() puts it back.
// A folder that a dead bake left is taken over and emptied by the next one; a live one's is locked.
// Owns the folder beside, and removes it. Not thread-safe, except write().
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/folder_lock.h"
#include "base/result.h"

namespace zc {

class WorldWriter {
 public:
  // Fails when `out` exists and is neither a world nor an empty directory, and while another bake writes it.
  static Result<WorldWriter> open(const std::filesystem::path& out);

  WorldWriter(WorldWriter&& other) noexcept = default;
  WorldWriter& operator=(WorldWriter&&) = delete;
  WorldWriter(const WorldWriter&) = delete;
  WorldWriter& operator=(const WorldWriter&) = delete;
  ~WorldWriter();

  // Where the world goes and an old one may be.
  [[nodiscard]] const std::filesystem::path& out() const { return out_; }

  Status make_directory(const std::string& relative);
  // Different files from different threads.
  Status write(const std::string& relative, std::span<const std::byte> bytes) const;
  Status write_text(const std::string& relative, std::string_view text) const;

  // The world takes its name; what was there before goes. may_exchange: false is for file systems that cannot.
  Status commit(bool may_exchange = true);

 private:
  WorldWriter(std::filesystem::path out, FolderLock lock);
  [[nodiscard]] std::filesystem::path fresh() const { return lock_.folder() / "world"; }
  [[nodiscard]] std::filesystem::path old() const { return lock_.folder() / "old"; }
  Status remove_leftovers() const;

  std::filesystem::path out_;
  FolderLock lock_;
};

}  // namespace zc
