// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/input_files.h"

#include <system_error>

#include "base/file.h"

namespace zc {
namespace {

class DiskFiles final : public InputFiles {
 public:
  [[nodiscard]] Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                    std::uint64_t limit_bytes) const override {
    Result<std::vector<std::byte>> bytes = read_file(file, limit_bytes);
    if (bytes.ok()) return bytes;
    Error error = std::move(bytes).error();
    std::error_code failure;
    if (std::filesystem::status(file, failure).type() == std::filesystem::file_type::not_found)
      error.code = ErrorCode::kMissing;
    return error;
  }
};

}  // namespace

const InputFiles& disk_files() {
  static const DiskFiles kFiles;
  return kFiles;
}

}  // namespace zc
