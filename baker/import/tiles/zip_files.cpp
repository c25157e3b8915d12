// SPDX-License-Identifier: GPL-3.0-or-later
// ZIP: PKWARE's APPNOTE 6.3.9. 3TZ: the 3D Tiles archive format, version 1.3.
#include "baker/import/tiles/zip_files.h"

#include <unzip.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "baker/import/shared/gunzip.h"
#include "baker/import/tiles/tile_files.h"
#include "base/file.h"

namespace zc {
namespace {

constexpr const char* kTilesetName = "tileset.json";
constexpr uLong kStored = 0;
constexpr uLong kDeflated = 8;
constexpr uLong kZstandard = 93;
constexpr uLong kFlagEncrypted = 1;

class ZipFiles final : public InputFiles {
 public:
  explicit ZipFiles(std::filesystem::path archive) : archive_(std::move(archive)) {}
  ~ZipFiles() override {
    if (zip_ != nullptr) unzClose(zip_);
  }

  // Once, before everything else.
  Status open() {
    ZC_ASSIGN(archive_bytes_, file_size_bytes(archive_));
    zip_ = unzOpen64(archive_.c_str());
    if (zip_ == nullptr) return error(kTilesetName, "is a damaged ZIP archive: get it again");
    std::string name;
    for (int state = unzGoToFirstFile(zip_); state == UNZ_OK; state = unzGoToNextFile(zip_)) {
      unz_file_info64 info = {};
      unz64_file_pos position = {};
      name.resize(0xFFFF);
      if (unzGetCurrentFileInfo64(zip_, &info, name.data(), name.size(), nullptr, 0, nullptr, 0) != UNZ_OK ||
          unzGetFilePos64(zip_, &position) != UNZ_OK)
        return error(kTilesetName, "is a damaged ZIP archive: get it again");
      entries_.emplace(name.substr(0, info.size_filename), position);
    }
    if (!entries_.contains(kTilesetName))
      return Error{
          ErrorCode::kUnsupported,
          "is a ZIP archive without a tileset.json, expected a 3D Tiles archive (.3tz); unpack it and bake what "
          "is in it",
          archive_.string()};
    return {};
  }

  [[nodiscard]] Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                    std::uint64_t limit_bytes) const override {
    const std::string name = file.lexically_relative(archive_).generic_string();
    const auto entry = entries_.find(name);
    if (entry == entries_.end()) {
      Error absent = error(name, "is not in the archive");
      absent.code = ErrorCode::kMissing;
      return absent;
    }
    unz64_file_pos position = entry->second;
    unz_file_info64 info = {};
    if (unzGoToFilePos64(zip_, &position) != UNZ_OK ||
        unzGetCurrentFileInfo64(zip_, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK)
      return damaged(name);
    if ((info.flag & kFlagEncrypted) != 0)
      return error(name, "is encrypted: write the archive without a password", ErrorCode::kUnsupported);
    const std::uint64_t limit =
        info.compression_method == kStored ? limit_bytes : std::min(limit_bytes, kMaxUnpackedBytes);
    if (info.compressed_size > archive_bytes_) return damaged(name);
    if (info.uncompressed_size > limit)
      return error(name, "unpacks to " + std::to_string(info.uncompressed_size) + " bytes, more than the " +
                             std::to_string(limit) + " allowed");
    ZC_ASSIGN(std::vector<std::byte> bytes, stored_bytes(name, info.compressed_size));
    if (info.compression_method != kStored) {
      ZC_ASSIGN(bytes, unpacked(bytes, info, name));
    }
    if (bytes.size() != info.uncompressed_size || checksum(bytes) != info.crc) return damaged(name);
    return bytes;
  }

 private:
  [[nodiscard]] Error error(const std::string& name, std::string message, ErrorCode code = ErrorCode::kFormat) const {
    return {code, std::move(message), (archive_ / name).string()};
  }
  [[nodiscard]] Error damaged(const std::string& name) const {
    return error(name, "is damaged in the archive: get the archive again");
  }

  // As they lie in the archive.
  [[nodiscard]] Result<std::vector<std::byte>> stored_bytes(const std::string& name, std::uint64_t count) const {
    int method = 0;
    int level = 0;
    constexpr int kRaw = 1;
    if (unzOpenCurrentFile2(zip_, &method, &level, kRaw) != UNZ_OK) return damaged(name);
    std::vector<std::byte> bytes(count);
    std::uint64_t have = 0;
    while (have < count) {
      const auto step = static_cast<unsigned>(std::min<std::uint64_t>(count - have, 1U << 30U));
      const int got = unzReadCurrentFile(zip_, bytes.data() + have, step);
      if (got <= 0) break;
      have += static_cast<std::uint64_t>(got);
    }
    unzCloseCurrentFile(zip_);
    if (have < count) return damaged(name);
    return bytes;
  }

  [[nodiscard]] Result<std::vector<std::byte>> unpacked(std::span<const std::byte> bytes, const unz_file_info64& info,
                                                        const std::string& name) const {
    if (info.compression_method == kDeflated)
      return inflate_raw(bytes, (archive_ / name).string(), info.uncompressed_size);
    if (info.compression_method != kZstandard)
      return error(name,
                   "is compressed by method " + std::to_string(info.compression_method) +
                       ": stored, deflated (8) and Zstandard (93) are read; write the archive so",
                   ErrorCode::kUnsupported);
    std::vector<std::byte> out(info.uncompressed_size);
    const std::size_t size = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
    if (ZSTD_isError(size) != 0 || size != out.size()) return damaged(name);
    return out;
  }

  static uLong checksum(std::span<const std::byte> bytes) {
    return crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  }

  std::filesystem::path archive_;
  std::uint64_t archive_bytes_ = 0;
  unzFile zip_ = nullptr;
  std::map<std::string, unz64_file_pos> entries_;
};

}  // namespace

bool is_zip(std::span<const std::byte> head) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  return text.starts_with("PK\x03\x04") || text.starts_with("PK\x05\x06");
}

Result<std::unique_ptr<InputFiles>> open_zip_files(const std::filesystem::path& archive) {
  auto files = std::make_unique<ZipFiles>(archive);
  ZC_TRY(files->open());
  return std::unique_ptr<InputFiles>(std::move(files));
}

}  // namespace zc
