// SPDX-License-Identifier: Apache-2.0
#include "replay/files/archive_writer.h"

#include <zip.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>
#include <utility>

#include "base/platform.h"

namespace zc {
namespace {

// What minizip writes goes through a stream whose position is known.
voidpf open_stream(voidpf stream, const void* /*name*/, int /*mode*/) { return stream; }
uLong write_stream(voidpf /*opaque*/, voidpf stream, const void* bytes, uLong count) {
  auto& out = *static_cast<std::fstream*>(stream);
  out.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  return out ? count : 0;
}
uLong read_stream(voidpf /*opaque*/, voidpf stream, void* bytes, uLong count) {
  auto& in = *static_cast<std::fstream*>(stream);
  in.read(static_cast<char*>(bytes), static_cast<std::streamsize>(count));
  return static_cast<uLong>(in.gcount());
}
ZPOS64_T tell_stream(voidpf /*opaque*/, voidpf stream) {
  return static_cast<ZPOS64_T>(static_cast<std::fstream*>(stream)->tellp());
}
long seek_stream(voidpf /*opaque*/, voidpf stream, ZPOS64_T offset, int origin) {
  constexpr std::array kOrigins = {std::ios::beg, std::ios::cur, std::ios::end};
  auto& out = *static_cast<std::fstream*>(stream);
  out.seekp(static_cast<std::streamoff>(offset), kOrigins.at(static_cast<std::size_t>(origin)));
  return out ? 0 : -1;
}
int close_stream(voidpf /*opaque*/, voidpf /*stream*/) { return 0; }
int error_of_stream(voidpf /*opaque*/, voidpf stream) { return *static_cast<std::fstream*>(stream) ? 0 : -1; }

}  // namespace

struct ArchiveWriter::Zip {
  std::filesystem::path path;
  std::filesystem::path draft;
  std::fstream stream;
  zipFile zip = nullptr;

  Zip() = default;
  Zip(const Zip&) = delete;
  Zip& operator=(const Zip&) = delete;
  ~Zip() {
    if (zip != nullptr) zipClose(zip, nullptr);
    stream.close();
    std::error_code code;
    if (!draft.empty()) std::filesystem::remove(draft, code);
  }
  [[nodiscard]] Error fault() const {
    return {ErrorCode::kIo, std::string("cannot write: ") + std::strerror(errno != 0 ? errno : EIO), path.string()};
  }
};

ArchiveWriter::ArchiveWriter(std::unique_ptr<Zip> zip) : zip_(std::move(zip)) {}
ArchiveWriter::ArchiveWriter(ArchiveWriter&&) noexcept = default;
ArchiveWriter::~ArchiveWriter() = default;

Result<ArchiveWriter> ArchiveWriter::create(const std::filesystem::path& path) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return Error{ErrorCode::kIo, "is there and not a file", path.string()};
  auto zip = std::make_unique<Zip>();
  zip->path = path;
  std::filesystem::path draft = path;
  draft += "." + process_name() + ".tmp";
  errno = 0;
  zip->stream.open(draft, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
  if (!zip->stream) return zip->fault();
  zip->draft = draft;
  zlib_filefunc64_def functions{open_stream, read_stream,  write_stream,    tell_stream,
                                seek_stream, close_stream, error_of_stream, nullptr};
  functions.opaque = &zip->stream;
  zip->zip = zipOpen2_64("", APPEND_STATUS_CREATE, nullptr, &functions);
  if (zip->zip == nullptr) return zip->fault();
  return ArchiveWriter(std::move(zip));
}

Status ArchiveWriter::add(const std::string& name, std::span<const std::byte> bytes) {
  entries_.push_back({archive_key(name), static_cast<std::uint64_t>(zip_->stream.tellp())});
  return store(name, bytes);
}

Status ArchiveWriter::store(const std::string& name, std::span<const std::byte> bytes) {
  // minizip counts in 32 bits; longer names are none of ours.
  if (bytes.size() >= std::numeric_limits<std::uint32_t>::max())
    return Error{ErrorCode::kUnsupported, "is 4 GiB or more, too much for an archive", name};
  zip_fileinfo info{};
  info.dosDate = 0x00210000;  // 1 January 1980, so that the same files give the same bytes
  errno = 0;
  if (zipOpenNewFileInZip64(zip_->zip, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, 0, 0, 0) != ZIP_OK ||
      zipWriteInFileInZip(zip_->zip, bytes.data(), static_cast<unsigned>(bytes.size())) != ZIP_OK ||
      zipCloseFileInZip(zip_->zip) != ZIP_OK || !zip_->stream)
    return zip_->fault();
  return {};
}

Status ArchiveWriter::commit() {
  std::sort(entries_.begin(), entries_.end(), [](const ArchiveEntry& a, const ArchiveEntry& b) {
    return a.key != b.key ? a.key < b.key : a.offset < b.offset;
  });
  ZC_TRY(store(kArchiveIndexName, std::as_bytes(std::span(entries_))));
  errno = 0;
  if (zipClose(std::exchange(zip_->zip, nullptr), nullptr) != ZIP_OK) return zip_->fault();
  zip_->stream.close();
  if (!zip_->stream) return zip_->fault();
  std::error_code code;
  std::filesystem::rename(zip_->draft, zip_->path, code);
  if (code) return Error{ErrorCode::kIo, "cannot write: " + code.message(), zip_->path.string()};
  zip_->draft.clear();
  return {};
}

}  // namespace zc
