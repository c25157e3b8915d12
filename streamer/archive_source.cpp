// SPDX-License-Identifier: Apache-2.0
#include "streamer/archive_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "streamer/archive_index.h"

namespace zc {
namespace {

class OpenFile {
 public:
  explicit OpenFile(int handle) : handle_(handle) {}
  OpenFile(OpenFile&& other) noexcept : handle_(std::exchange(other.handle_, -1)) {}
  OpenFile& operator=(OpenFile&&) = delete;
  ~OpenFile() {
    if (handle_ >= 0) ::close(handle_);
  }
  [[nodiscard]] int handle() const { return handle_; }

 private:
  int handle_;
};

class ArchiveSource final : public Source {
 public:
  ArchiveSource(OpenFile file, std::string path, std::uint64_t bytes)
      : file_(std::move(file)), path_(std::move(path)), bytes_(bytes) {}

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
    ZC_ASSIGN(const Place place, find(name));
    if (place.bytes > limit_bytes)
      return fault(name, "is " + std::to_string(place.bytes) + " bytes, more than " + std::to_string(limit_bytes));
    return read_place(place, name);
  }

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
  };

  [[nodiscard]] Error fault(const std::string& name, std::string what, ErrorCode code = ErrorCode::kFormat) const {
    return {code, std::move(what), path_ + ": " + name};
  }

  Status read_at(std::uint64_t offset, std::span<std::byte> out, const std::string& name) const {
    if (offset > bytes_ || out.size() > bytes_ - offset) return fault(name, "lies outside the archive");
    for (std::size_t done = 0; done < out.size();) {
      const ssize_t got =
          ::pread(file_.handle(), out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return fault(name, std::strerror(errno), ErrorCode::kIo);
      if (got == 0) return fault(name, "the archive became shorter", ErrorCode::kIo);
      done += static_cast<std::size_t>(got);
    }
    return {};
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

  OpenFile file_;
  std::string path_;
  std::uint64_t bytes_;
  std::uint64_t index_at_ = 0;
  std::uint64_t entries_ = 0;
};

}  // namespace

Result<std::unique_ptr<Source>> open_archive_source(const std::filesystem::path& path) {
  const std::string name = path.string();
  OpenFile file(::open(name.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.handle() < 0 || ::fstat(file.handle(), &status) != 0)
    return Error{ErrorCode::kIo, std::string("cannot open: ") + std::strerror(errno), name};
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::kIo, "not a regular file", name};
  const auto bytes = static_cast<std::uint64_t>(status.st_size);

  auto source = std::make_unique<ArchiveSource>(std::move(file), name, bytes);
  ZC_TRY(source->find_index());
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace zc
