// SPDX-License-Identifier: Apache-2.0
// A folder that one process at a time has: made if it is not there, kept by a lock on a file in it that ends with the
// process, however that ends. What a dead process left in the folder is still there for the next one.
// Owns the lock file and the folder: both go with it, the folder unless something else is in it.
// Fails when another process has it, or the file system refuses.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/result.h"

namespace zc {

class FolderLock {
 public:
  // Nothing when another process has the folder. lock_name: of a file that is nobody else's; it goes with the lock.
  static Result<std::optional<FolderLock>> take(const std::filesystem::path& folder,
                                                const std::string& lock_name = "lock");

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

  [[nodiscard]] bool is_held() const { return fd_ >= 0; }  // not moved from
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  FolderLock(std::filesystem::path folder, std::filesystem::path file, int fd);

  std::filesystem::path folder_;
  std::filesystem::path file_;
  int fd_;  // -1 once moved from
};

}  // namespace zc
