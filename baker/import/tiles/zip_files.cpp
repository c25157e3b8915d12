// SPDX-License-Identifier: GPL-3.0-or-later
// ZIP: PKWARE's APPNOTE 6.3.9. 3TZ: the 3D Tiles archive format, version 1.3.
#include "baker/import/tiles/zip_files.h"

#include <unzip.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>
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
constexpr std::size_t kLocalHeaderBytes = 30;  // before the name
constexpr std::uint32_t kLocalHeaderMagic = 0x04034B50;
constexpr std::size_t kEntryBytes = 46;  // of the directory, before the name
constexpr std::uint32_t kIn64 = 0xFFFFFFFF;
constexpr std::uint16_t kWideField = 1;

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

class ZipFiles final : public InputFiles {
 public:
  explicit ZipFiles(std::filesystem::path archive) : archive_(std::move(archive)) {}
  ~ZipFiles() override {
    if (zip_ != nullptr) unzClose(zip_);
  }

  // Once, before everything else.
  Status open() {
    ZC_ASSIGN(InputFile file, InputFile::open(archive_));
    file_.emplace(std::move(file));
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
    if (info.compressed_size > file_->size_bytes()) return damaged(name);
    if (info.uncompressed_size > limit)
      return error(name, "unpacks to " + std::to_string(info.uncompressed_size) + " bytes, more than the " +
                             std::to_string(limit) + " allowed");
    ZC_ASSIGN(std::vector<std::byte> bytes, stored_bytes(name, position.pos_in_zip_directory, info.compressed_size));
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

  // As they lie in the archive: minizip itself opens no file of a method that it does not know.
  [[nodiscard]] Result<std::vector<std::byte>> stored_bytes(const std::string& name, std::uint64_t entry_at,
                                                            std::uint64_t count) const {
    ZC_ASSIGN(const std::uint64_t header_at, local_header(name, entry_at));
    std::array<std::byte, kLocalHeaderBytes> header{};
    if (!file_->read(header_at, header).ok() || number_at<std::uint32_t>(header, 0) != kLocalHeaderMagic)
      return damaged(name);
    std::vector<std::byte> bytes(count);
    const std::uint64_t data_at =
        header_at + kLocalHeaderBytes + number_at<std::uint16_t>(header, 26) + number_at<std::uint16_t>(header, 28);
    if (!file_->read(data_at, bytes).ok()) return damaged(name);
    return bytes;
  }

  // Where it is, from the entry of the archive's directory, in which numbers beyond 32 bits stand in a field behind.
  [[nodiscard]] Result<std::uint64_t> local_header(const std::string& name, std::uint64_t entry_at) const {
    std::array<std::byte, kEntryBytes> entry{};
    if (!file_->read(entry_at, entry).ok()) return damaged(name);
    const auto offset = number_at<std::uint32_t>(entry, 42);
    if (offset != kIn64) return offset;
    std::vector<std::byte> fields(number_at<std::uint16_t>(entry, 30));
    if (!file_->read(entry_at + kEntryBytes + number_at<std::uint16_t>(entry, 28), fields).ok()) return damaged(name);
    std::size_t skipped = 4;
    for (const std::size_t size_at : {std::size_t{20}, std::size_t{24}})
      if (number_at<std::uint32_t>(entry, size_at) == kIn64) skipped += 8;
    for (std::size_t at = 0; at + 4 <= fields.size(); at += 4 + std::size_t{number_at<std::uint16_t>(fields, at + 2)})
      if (number_at<std::uint16_t>(fields, at) == kWideField && at + skipped + 8 <= fields.size())
        return number_at<std::uint64_t>(fields, at + skipped);
    return damaged(name);
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
  std::optional<InputFile> file_;
  unzFile zip_ = nullptr;
  std::map<std::string, unz64_file_pos> entries_;
};

}  // namespace

Result<std::unique_ptr<InputFiles>> open_zip_files(const std::filesystem::path& archive) {
  auto files = std::make_unique<ZipFiles>(archive);
  ZC_TRY(files->open());
  return std::unique_ptr<InputFiles>(std::move(files));
}

}  // namespace zc
