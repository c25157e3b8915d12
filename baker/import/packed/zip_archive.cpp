// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/packed/zip_archive.h"

#include <unzip.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

#include "baker/import/packed/unpack_limit.h"
#include "baker/import/shared/gunzip.h"

namespace zc {
namespace {

constexpr uLong kEncryptedFlag = 1;
constexpr uLong kStored = 0;
constexpr uLong kDeflated = 8;
constexpr uLong kZstandard = 93;
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

Error damaged(const std::filesystem::path& file) {
  return {ErrorCode::kFormat, "is damaged or cut short, expected a whole ZIP archive; get it anew", file.string()};
}

// With '/' between folders, as the format asks for and not every program writes. Empty for folders, and for names that
// lead out of the archive.
std::string entry_name(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  if (name.ends_with('/') || path.is_absolute() || path.empty() || *path.begin() == "..") return {};
  return path.generic_string();
}

}  // namespace

Result<std::unique_ptr<ZipArchive>> ZipArchive::open(const std::filesystem::path& archive) {
  ZC_ASSIGN(InputFile file, InputFile::open(archive));
  std::unique_ptr<ZipArchive> zip(new ZipArchive(archive, std::move(file)));
  const std::unique_ptr<void, decltype(&unzClose)> handle(unzOpen64(archive.c_str()), &unzClose);
  if (handle == nullptr) return damaged(archive);
  ZC_TRY(zip->list(handle.get()));
  return zip;
}

Status ZipArchive::list(void* handle) {
  unz_global_info64 all = {};
  if (unzGetGlobalInfo64(handle, &all) != UNZ_OK) return damaged(archive_);
  if (all.number_entry == 0) return {};
  int state = unzGoToFirstFile(handle);
  for (; state == UNZ_OK; state = unzGoToNextFile(handle)) {
    unz_file_info64 info = {};
    if (unzGetCurrentFileInfo64(handle, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK) break;
    std::string name(info.size_filename, '\0');
    unz64_file_pos place = {};
    if (unzGetCurrentFileInfo64(handle, &info, name.data(), info.size_filename, nullptr, 0, nullptr, 0) != UNZ_OK ||
        unzGetFilePos64(handle, &place) != UNZ_OK)
      break;
    if (name = entry_name(std::move(name)); !name.empty())
      entries_.try_emplace(std::move(name),
                           Entry{place.pos_in_zip_directory, info.compressed_size, info.uncompressed_size,
                                 info.compression_method, info.crc, (info.flag & kEncryptedFlag) != 0});
  }
  return state == UNZ_END_OF_LIST_OF_FILE ? Status() : damaged(archive_);
}

std::vector<std::string> ZipArchive::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

Result<std::vector<std::byte>> ZipArchive::read(const std::filesystem::path& file, std::uint64_t limit_bytes) const {
  const auto inside = file.lexically_normal().lexically_relative(archive_.lexically_normal());
  const auto found = entries_.find(inside.generic_string());
  if (found == entries_.end()) return Error{ErrorCode::kMissing, "is not in the archive", file.string()};
  const Entry& entry = found->second;
  if (entry.encrypted || (entry.method != kStored && entry.method != kDeflated && entry.method != kZstandard))
    return Error{ErrorCode::kUnsupported,
                 (entry.encrypted ? "is encrypted" : "is compressed by method " + std::to_string(entry.method)) +
                     ", expected deflate (8) or Zstandard (93) and no password; unpack the archive and bake what is in "
                     "it",
                 file.string()};
  if (entry.bytes > limit_bytes)
    return Error{
        ErrorCode::kFormat,
        "is " + std::to_string(entry.bytes) + " bytes, more than the " + std::to_string(limit_bytes) + " allowed",
        file.string()};
  if (entry.bytes > unpack_limit(entry.packed_bytes)) return unpacks_too_far(entry.packed_bytes, file.string());
  // Files may share their bytes in the archive.
  if (!std::exchange(entry.counted, true)) unpacked_ += entry.bytes;
  if (unpacked_ > unpack_limit(file_.size_bytes())) return unpacks_too_far(file_.size_bytes(), archive_.string());
  ZC_ASSIGN(std::vector<std::byte> bytes, packed(entry, file));
  if (entry.method == kDeflated) {
    Result<std::vector<std::byte>> whole = inflate_raw(bytes, file.string(), entry.bytes);
    if (!whole.ok()) return damaged(file);
    bytes = std::move(*whole);
  } else if (entry.method == kZstandard) {
    std::vector<std::byte> whole(entry.bytes);
    const std::size_t size = ZSTD_decompress(whole.data(), whole.size(), bytes.data(), bytes.size());
    if (ZSTD_isError(size) != 0 || size != whole.size()) return damaged(file);
    bytes = std::move(whole);
  }
  const uLong checksum = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  if (bytes.size() != entry.bytes || checksum != entry.checksum) return damaged(file);
  return bytes;
}

// As they lie in the archive: minizip itself opens no file of a method that it does not know.
Result<std::vector<std::byte>> ZipArchive::packed(const Entry& entry, const std::filesystem::path& file) const {
  if (entry.packed_bytes > file_.size_bytes()) return damaged(file);
  ZC_ASSIGN(const std::uint64_t header_at, local_header(entry, file));
  std::array<std::byte, kLocalHeaderBytes> header{};
  if (!file_.read(header_at, header).ok() || number_at<std::uint32_t>(header, 0) != kLocalHeaderMagic)
    return damaged(file);
  std::vector<std::byte> bytes(entry.packed_bytes);
  const std::uint64_t data_at =
      header_at + kLocalHeaderBytes + number_at<std::uint16_t>(header, 26) + number_at<std::uint16_t>(header, 28);
  if (!file_.read(data_at, bytes).ok()) return damaged(file);
  return bytes;
}

// Where it is, from the entry of the archive's directory, in which numbers beyond 32 bits stand in a field behind.
Result<std::uint64_t> ZipArchive::local_header(const Entry& entry, const std::filesystem::path& file) const {
  std::array<std::byte, kEntryBytes> head{};
  if (!file_.read(entry.place, head).ok()) return damaged(file);
  const auto offset = number_at<std::uint32_t>(head, 42);
  if (offset != kIn64) return offset;
  std::vector<std::byte> fields(number_at<std::uint16_t>(head, 30));
  if (!file_.read(entry.place + kEntryBytes + number_at<std::uint16_t>(head, 28), fields).ok()) return damaged(file);
  std::size_t skipped = 4;
  for (const std::size_t size_at : {std::size_t{20}, std::size_t{24}})
    if (number_at<std::uint32_t>(head, size_at) == kIn64) skipped += 8;
  for (std::size_t at = 0; at + 4 <= fields.size(); at += 4 + std::size_t{number_at<std::uint16_t>(fields, at + 2)})
    if (number_at<std::uint16_t>(fields, at) == kWideField && at + skipped + 8 <= fields.size())
      return number_at<std::uint64_t>(fields, at + skipped);
  return damaged(file);
}

}  // namespace zc
