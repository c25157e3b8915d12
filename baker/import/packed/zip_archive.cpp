// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/packed/zip_archive.h"

#include <unzip.h>

#include <algorithm>
#include <utility>

#include "baker/import/packed/unpack_limit.h"
#include "baker/import/shared/json_text.h"
#include "base/file.h"

namespace zc {
namespace {

constexpr unsigned kEncryptedFlag = 1;
constexpr unsigned kStored = 0;
constexpr unsigned kDeflated = 8;
constexpr const char* kDamaged = "is damaged or cut short, expected a whole ZIP archive; get it anew";

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
  ZC_ASSIGN(const std::uint64_t bytes, file_size_bytes(archive));
  const unzFile handle = unzOpen64(archive.c_str());
  if (handle == nullptr) return Error{ErrorCode::kFormat, kDamaged, archive.string()};
  std::unique_ptr<ZipArchive> zip(new ZipArchive(archive, handle));
  zip->packed_bytes_ = bytes;
  ZC_TRY(zip->list());
  return zip;
}

ZipArchive::~ZipArchive() { unzClose(handle_); }

Status ZipArchive::list() {
  unz_global_info64 all = {};
  if (unzGetGlobalInfo64(handle_, &all) != UNZ_OK) return error(kDamaged, archive_);
  if (all.number_entry == 0) return {};
  int state = unzGoToFirstFile(handle_);
  for (; state == UNZ_OK; state = unzGoToNextFile(handle_)) {
    unz_file_info64 info = {};
    if (unzGetCurrentFileInfo64(handle_, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK) break;
    std::string name(info.size_filename, '\0');
    unz64_file_pos place = {};
    if (unzGetCurrentFileInfo64(handle_, &info, name.data(), info.size_filename, nullptr, 0, nullptr, 0) != UNZ_OK ||
        unzGetFilePos64(handle_, &place) != UNZ_OK)
      break;
    if (name = entry_name(std::move(name)); !name.empty())
      entries_.try_emplace(std::move(name),
                           Entry{place.pos_in_zip_directory, place.num_of_file, info.compressed_size,
                                 info.uncompressed_size, (info.flag & kEncryptedFlag) != 0,
                                 info.compression_method == kStored || info.compression_method == kDeflated});
  }
  return state == UNZ_END_OF_LIST_OF_FILE ? Status() : error(kDamaged, archive_);
}

std::vector<std::string> ZipArchive::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

Error ZipArchive::error(const std::string& message, const std::filesystem::path& file) const {
  return {ErrorCode::kFormat, message, file.string()};
}

Result<std::vector<std::byte>> ZipArchive::read(const std::filesystem::path& file, std::uint64_t limit_bytes) const {
  const auto inside = file.lexically_normal().lexically_relative(archive_.lexically_normal());
  const auto found = entries_.find(inside.generic_string());
  if (found == entries_.end()) return Error{ErrorCode::kMissing, "is not in the archive", file.string()};
  const Entry& entry = found->second;
  if (entry.encrypted || !entry.known_method)
    return Error{ErrorCode::kUnsupported,
                 std::string(entry.encrypted ? "is encrypted" : "is packed by a method of its own") +
                     ", expected deflate and no password; unpack the archive and bake what is in it",
                 file.string()};
  if (entry.bytes > limit_bytes)
    return error(
        "is " + std::to_string(entry.bytes) + " bytes, more than the " + std::to_string(limit_bytes) + " allowed",
        file);
  if (entry.bytes > unpack_limit(entry.packed_bytes)) return unpacks_too_far(entry.packed_bytes, file.string());
  // Files may share their bytes in the archive.
  unpacked_ += entry.bytes;
  if (unpacked_ > unpack_limit(packed_bytes_)) return unpacks_too_far(packed_bytes_, archive_.string());
  unz64_file_pos place = {};
  place.pos_in_zip_directory = entry.place;
  place.num_of_file = entry.number;
  if (unzGoToFilePos64(handle_, &place) != UNZ_OK || unzOpenCurrentFile(handle_) != UNZ_OK)
    return error(kDamaged, file);
  std::vector<std::byte> bytes(entry.bytes);
  std::size_t done = 0;
  for (int got = 1; got > 0 && done < bytes.size(); done += static_cast<std::size_t>(std::max(got, 0))) {
    const std::size_t step = std::min<std::size_t>(bytes.size() - done, std::size_t{1} << 24U);
    got = unzReadCurrentFile(handle_, bytes.data() + done, static_cast<unsigned>(step));
  }
  const bool whole = unzCloseCurrentFile(handle_) == UNZ_OK && done == bytes.size();
  if (!whole) return error(kDamaged, file);
  return bytes;
}

}  // namespace zc
