// SPDX-License-Identifier: Apache-2.0
// Where a world's files come from: a directory, an archive, anything that reads named files by size.
// Owns: nothing that callers see · threads: every method may be called from several threads at once · untrusted input:
// names with ".." or absolute names are refused, sizes are checked before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

class Source {
 public:
  virtual ~Source() = default;

  // The whole file `name`, which must be exactly `bytes` long: a file of another size is an error, not a short buffer.
  virtual Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) = 0;

  // The whole file `name`, whatever its size up to limit_bytes.
  virtual Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) = 0;
};

// A directory, or a .3tz archive (archive_source.h). Fails when it is neither.
Result<std::unique_ptr<Source>> open_source(const std::filesystem::path& place);

// Fails when `dir` is not a directory.
Result<std::unique_ptr<Source>> open_directory_source(const std::filesystem::path& dir);

}  // namespace zc
