// SPDX-License-Identifier: Apache-2.0
// A folder that goes with its owner. Fails when there is no place for it.
#pragma once

#include <filesystem>

#include "base/platform.h"
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
    ZC_ASSIGN(path_, make_temporary_folder("zonecast"));
    return {};
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace zc
