// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/index_file.h"

#include <memory>

namespace zc {

Result<WorldIndex> read_world_index(Source& source, const std::filesystem::path& place, std::uint64_t limit_bytes) {
  ZC_ASSIGN(const std::unique_ptr<SourceFile> file, source.open(kWorldIndexName, limit_bytes));
  const ReadAt read = [&](std::uint64_t offset, std::span<std::byte> out) { return file->read(offset, out); };
  return decode_world_index(file->size_bytes(), read, (place / kWorldIndexName).string());
}

}  // namespace zc
