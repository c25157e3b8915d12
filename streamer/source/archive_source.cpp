// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/archive_source.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "base/file.h"
#include "streamer/source/archive_index.h"

namespace zc {
namespace {

class ArchiveSource final : public Source {
 public:
  ArchiveSource(InputFile file, std::string path)
      : file_(std::move(file)), path_(std::move(path)), bytes_(file_.size_bytes()) {}

  // Once, before everything else.
  Status find_index() {
    std::vector<std::byte> tail(std::min<std::uint64_t>(bytes_, kArchiveTailBytes));
    ZC_TRY(read_at(bytes_ - tail.size(), tail, kArchiveIndexName));
    const auto header_at = find_archive_index(tail);
    if (!header_at) return Error{header_at.error().code, header_at.error().message, path_};
    ZC_ASSIGN(const std::optional<Place> place, place_at(*header_at, kArchiveIndexName));
    if (!place || place->bytes % kArchiveEntryBytes != 0)
      return Error{ErrorCode::kFormat, "its index is no list of entries: not a 3D Tiles archive", path_};
    index_at_ = place->offset;
    entries_ = place->bytes / kArchiveEntryBytes;
    return {};
  }

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    ZC_ASSIGN(const Place place, find(name));
    if (place.bytes != bytes)
      return fault(name, "is " + std::to_string(place.bytes) + " bytes, the index says " + std::to_string(bytes));
    return read_place(place, name);
  }

  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const Place place, find_within(name, limit_bytes));
    return read_place(place, name);
  }

  Result<std::unique_ptr<SourceFile>> open(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const Place place, find_within(name, limit_bytes));
    return std::unique_ptr<SourceFile>(std::make_unique<Member>(*this, place, name));
  }

  [[nodiscard]] SourceCosts costs() const override { return {.whole_files = false}; }

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
  };

  class Member final : public SourceFile {
   public:
    Member(const ArchiveSource& archive, const Place& place, std::string name)
        : archive_(archive), place_(place), name_(std::move(name)) {}
    [[nodiscard]] std::uint64_t size_bytes() const override { return place_.bytes; }
    Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const override {
      if (offset_bytes > place_.bytes || out.size() > place_.bytes - offset_bytes)
        return archive_.fault(name_, "ends early");
      return archive_.read_at(place_.offset + offset_bytes, out, name_);
    }

   private:
    const ArchiveSource& archive_;
    const Place place_;
    const std::string name_;
  };

  [[nodiscard]] Error fault(const std::string& name, std::string what, ErrorCode code = ErrorCode::kFormat) const {
    return {code, std::move(what), path_ + ": " + name};
  }

  Status read_at(std::uint64_t offset, std::span<std::byte> out, const std::string& name) const {
    if (offset > bytes_ || out.size() > bytes_ - offset) return fault(name, "lies outside the archive");
    Status read = file_.read(offset, out);
    if (!read.ok()) return fault(name, read.error().message, read.error().code);
    return read;
  }

  [[nodiscard]] Result<Place> find_within(const std::string& name, std::uint64_t limit_bytes) const {
    ZC_ASSIGN(const Place place, find(name));
    if (place.bytes > limit_bytes)
      return fault(name, "is " + std::to_string(place.bytes) + " bytes, more than " + std::to_string(limit_bytes));
    return place;
  }

  [[nodiscard]] Result<Place> find(const std::string& name) const {
    const ArchiveKey key = archive_key(name);
    std::uint64_t first = 0;
    for (std::uint64_t count = entries_; count > 0;) {  // the first entry that is not below the key
      const std::uint64_t half = count / 2;
      ZC_ASSIGN(const ArchiveEntry entry, entry_at(first + half));
      if (entry.key < key) {
        first += half + 1;
        count -= half + 1;
      } else {
        count = half;
      }
    }
    for (; first < entries_; ++first) {  // names may share a hash
      ZC_ASSIGN(const ArchiveEntry entry, entry_at(first));
      if (entry.key != key) break;
      ZC_ASSIGN(const std::optional<Place> place, place_at(entry.offset, name));
      if (place) return *place;
    }
    return fault(name, "is not in the archive", ErrorCode::kIo);
  }

  // Where the data of the file with this local header lies; nothing where the file has another name.
  [[nodiscard]] Result<std::optional<Place>> place_at(std::uint64_t header_at, const std::string& name) const {
    std::vector<std::byte> front(kLocalHeaderBytes + name.size());
    ZC_TRY(read_at(header_at, front, name));
    const auto header = read_local_header(front);
    if (!header) return fault(name, header.error().message, header.error().code);
    if (header->name != name) return std::optional<Place>();
    const std::uint64_t data = header_at + header->data_at;
    // Before anybody takes memory for it.
    if (data > bytes_ || header->bytes > bytes_ - data) return fault(name, "lies outside the archive");
    return std::optional<Place>(Place{data, header->bytes});
  }

  [[nodiscard]] Result<ArchiveEntry> entry_at(std::uint64_t i) const {
    ArchiveEntry entry;
    ZC_TRY(
        read_at(index_at_ + i * kArchiveEntryBytes, std::as_writable_bytes(std::span(&entry, 1)), kArchiveIndexName));
    return entry;
  }

  [[nodiscard]] Result<std::vector<std::byte>> read_place(const Place& place, const std::string& name) const {
    std::vector<std::byte> out(place.bytes);
    ZC_TRY(read_at(place.offset, out, name));
    return out;
  }

  InputFile file_;
  std::string path_;
  std::uint64_t bytes_;
  std::uint64_t index_at_ = 0;
  std::uint64_t entries_ = 0;
};

}  // namespace

Result<std::unique_ptr<Source>> open_archive_source(const std::filesystem::path& path) {
  ZC_ASSIGN(InputFile file, InputFile::open(path));
  auto source = std::make_unique<ArchiveSource>(std::move(file), path.string());
  ZC_TRY(source->find_index());
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace zc
