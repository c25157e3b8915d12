// SPDX-License-Identifier: Apache-2.0
// A folder that goes with its owner. Fails when there is no place for it.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>

#include "base/result.h"

namespace zc {

class TemporaryFolder {
 public:
  TemporaryFolder() = default;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  Status create() {
    std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-bench-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) return Error{ErrorCode::kIo, "cannot make a temporary folder", pattern};
    path_ = pattern;
    return {};
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace zc
