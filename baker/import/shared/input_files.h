// SPDX-License-Identifier: GPL-3.0-or-later
// Where the files of an input are read from: the disk, an archive or a server. Untrusted input: sizes are checked
// before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"

namespace zc {

class InputFiles {
 public:
  InputFiles() = default;
  InputFiles(const InputFiles&) = delete;
  InputFiles& operator=(const InputFiles&) = delete;
  virtual ~InputFiles() = default;

  // The whole file. Fails with kMissing when it is not there, otherwise when it is unreadable or larger than
  // limit_bytes.
  [[nodiscard]] virtual Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                            std::uint64_t limit_bytes) const = 0;
};

const InputFiles& disk_files();

}  // namespace zc
