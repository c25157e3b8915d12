// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/tile_files.h"

#include <utility>

#include "baker/import/shared/gunzip.h"

namespace zc {
namespace {

constexpr std::size_t kNamesShown = 8;

}  // namespace

Result<std::optional<std::vector<std::byte>>> TileFiles::read(const std::filesystem::path& file,
                                                              std::uint64_t limit_bytes) {
  Result<std::vector<std::byte>> bytes = from_.read(file, limit_bytes);
  if (!bytes.ok()) {
    ZC_TRY(settle(std::move(bytes).error()));
    return std::optional<std::vector<std::byte>>();
  }
  if (is_gzip(*bytes)) {
    ZC_ASSIGN(*bytes, gunzip(*bytes, file.string(), kMaxUnpackedBytes));
  }
  return std::optional(*std::move(bytes));
}

Status TileFiles::settle(Status status) {
  if (status.ok() || status.error().code != ErrorCode::kMissing) return status;
  Error error = std::move(status).error();
  if (!skip_missing_) {
    error.message += "; --skip-missing bakes the tileset without what is not there";
    return error;
  }
  ++missing_;
  if (first_missing_.size() < kNamesShown) first_missing_.push_back(error.path);
  return {};
}

void TileFiles::report(SceneBuilder& builder) const {
  builder.note_missing("files of tiles that are not there, left out", missing_, first_missing_);
}

}  // namespace zc
