// SPDX-License-Identifier: Apache-2.0
#include "streamer/source.h"

#include <algorithm>
#include <system_error>

#include "base/file.h"
#include "streamer/archive_source.h"

namespace zc {
namespace {

class DirectorySource final : public Source {
 public:
  explicit DirectorySource(std::filesystem::path dir) : dir_(std::move(dir)) {}

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    ZC_ASSIGN(const std::filesystem::path path, locate(name));
    ZC_ASSIGN(const std::uint64_t size, file_size_bytes(path));
    if (size != bytes)
      return Error{ErrorCode::kFormat, "is " + std::to_string(size) + " bytes, the index says " + std::to_string(bytes),
                   path.string()};
    std::vector<std::byte> out(bytes);
    ZC_TRY(read_range(path, 0, out));
    return out;
  }

  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const std::filesystem::path path, locate(name));
    return read_file(path, limit_bytes);
  }

 private:
  [[nodiscard]] Result<std::filesystem::path> locate(const std::string& name) const {
    const std::filesystem::path relative(name);
    if (name.empty() || relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end())
      return Error{ErrorCode::kArgument, "name leaves the world", name};
    return dir_ / relative;
  }

  std::filesystem::path dir_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_source(const std::filesystem::path& place) {
  std::error_code code;
  if (std::filesystem::is_directory(place, code)) return open_directory_source(place);
  if (!std::filesystem::exists(place, code)) return Error{ErrorCode::kIo, "no such world", place.string()};
  return open_archive_source(place);
}

Result<std::unique_ptr<Source>> open_directory_source(const std::filesystem::path& dir) {
  std::error_code code;
  if (!std::filesystem::is_directory(dir, code)) return Error{ErrorCode::kIo, "not a directory", dir.string()};
  return std::unique_ptr<Source>(std::make_unique<DirectorySource>(dir));
}

}  // namespace zc
