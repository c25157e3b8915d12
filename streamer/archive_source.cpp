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
#include <string_view>
#include <utility>

#include "streamer/archive_index.h"

namespace zc {
namespace {

// PKWARE's APPNOTE, 4.3.7: what stands before a file's name, of which these are read.
constexpr std::size_t kLocalHeaderBytes = 30;
constexpr std::uint32_t kLocalHeaderMagic = 0x04034B50;
constexpr std::size_t kCentralHeaderBytes = 46;  // 4.3.12
constexpr std::uint32_t kCentralHeaderMagic = 0x02014B50;
constexpr std::uint64_t kTailBytes = 1024;   // in which the last entry is found
constexpr std::uint64_t kIn64 = 0xFFFFFFFF;  // the number does not fit and stands elsewhere
constexpr std::uint16_t kFlagEncrypted = 1;
constexpr std::uint16_t kFlagSizesBehind = 8;

template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

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
    // The index is the last file: its entry in the ZIP's directory, the last too, lies near the archive's end.
    std::vector<std::byte> tail(std::min(bytes_, kTailBytes));
    ZC_TRY(read_at(bytes_ - tail.size(), tail, kArchiveIndexName));
    const std::string_view name = kArchiveIndexName;
    for (std::size_t at = tail.size() - std::min(tail.size(), kCentralHeaderBytes + name.size()) + 1; at-- > 0;) {
      const std::span<const std::byte> entry = std::span(tail).subspan(at);
      if (entry.size() < kCentralHeaderBytes + name.size() || number_at<std::uint32_t>(entry, 0) != kCentralHeaderMagic)
        continue;
      if (number_at<std::uint16_t>(entry, 28) != name.size() ||
          std::memcmp(entry.data() + kCentralHeaderBytes, name.data(), name.size()) != 0)
        break;  // another file is the last
      std::uint64_t header_at = number_at<std::uint32_t>(entry, 42);
      if (header_at == kIn64) {
        ZC_ASSIGN(header_at, wide_offset(entry.subspan(kCentralHeaderBytes + name.size())));
      }
      ZC_ASSIGN(const std::optional<Place> place, place_at(header_at, kArchiveIndexName));
      if (!place || place->bytes % kArchiveEntryBytes != 0) break;
      index_at_ = place->offset;
      entries_ = place->bytes / kArchiveEntryBytes;
      return {};
    }
    return Error{ErrorCode::kFormat, "has no index as its last file: not a 3D Tiles archive", path_};
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

  // The offset of a file beyond 4 GiB, in its entry's field for such numbers (APPNOTE 4.5.3), which alone has it here:
  // the index itself is smaller.
  [[nodiscard]] Result<std::uint64_t> wide_offset(std::span<const std::byte> extra) const {
    constexpr std::uint16_t kWideField = 1;
    if (extra.size() < 12 || number_at<std::uint16_t>(extra, 0) != kWideField || number_at<std::uint16_t>(extra, 2) < 8)
      return fault(kArchiveIndexName, "its place in the archive is missing");
    return number_at<std::uint64_t>(extra, 4);
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
    std::array<std::byte, kLocalHeaderBytes> header{};
    ZC_TRY(read_at(header_at, header, name));
    if (number_at<std::uint32_t>(header, 0) != kLocalHeaderMagic)
      return fault(name, "the archive's index does not lead to a file");
    const std::uint64_t name_bytes = number_at<std::uint16_t>(header, 26);
    std::string found(name_bytes, '\0');
    ZC_TRY(read_at(header_at + kLocalHeaderBytes, std::as_writable_bytes(std::span(found)), name));
    if (found != name) return std::optional<Place>();
    const auto flags = number_at<std::uint16_t>(header, 6);
    const auto method = number_at<std::uint16_t>(header, 8);
    const auto stored_bytes = number_at<std::uint32_t>(header, 18);
    if (method != 0 || (flags & (kFlagEncrypted | kFlagSizesBehind)) != 0 || stored_bytes == kIn64)
      return fault(name, "is not stored as it is in the archive", ErrorCode::kUnsupported);
    const std::uint64_t data = header_at + kLocalHeaderBytes + name_bytes + number_at<std::uint16_t>(header, 28);
    // Before anybody takes memory for it.
    if (data > bytes_ || stored_bytes > bytes_ - data) return fault(name, "lies outside the archive");
    return std::optional<Place>(Place{data, stored_bytes});
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
