// SPDX-License-Identifier: Apache-2.0
#include "base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/platform.h"

namespace zc {
namespace {

Error io_error(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kIo, std::string(what) + ": " + std::strerror(errno), path.string()};
}

// Closes on scope exit; after writing, finish() does, for a network file system may refuse the bytes only then.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool finish() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

// path: the name that errors speak of.
Status write_bytes(const std::filesystem::path& at, int flags, const std::filesystem::path& path,
                   std::span<const std::span<const std::byte>> parts) {
  Descriptor file(::open(at.c_str(), O_WRONLY | O_CLOEXEC | flags, 0644));
  if (file.get() < 0) return io_error(path, "cannot create");
  for (std::span<const std::byte> bytes : parts) {
    while (!bytes.empty()) {
      const ssize_t put = ::write(file.get(), bytes.data(), bytes.size());
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return io_error(path, "cannot write");
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
  }
  if (!file.finish()) return io_error(path, "cannot write");
  return {};
}

}  // namespace

// A pipe with nobody at its other end is not waited for.
Result<InputFile> InputFile::open(const std::filesystem::path& path, std::uint64_t limit_bytes) {
  InputFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), path.string());
  struct stat info {};
  if (file.handle_ < 0 || ::fstat(file.handle_, &info) != 0) return io_error(path, "cannot open");
  if (!S_ISREG(info.st_mode)) return Error{ErrorCode::kIo, "not a regular file", path.string()};
  file.size_bytes_ = static_cast<std::uint64_t>(info.st_size);
  if (file.size_bytes_ > limit_bytes)
    return Error{
        ErrorCode::kFormat,
        "is " + std::to_string(file.size_bytes_) + " bytes, more than the " + std::to_string(limit_bytes) + " allowed",
        path.string()};
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : handle_(std::exchange(other.handle_, -1)), size_bytes_(other.size_bytes_), path_(std::move(other.path_)) {}

InputFile::~InputFile() {
  if (handle_ >= 0) ::close(handle_);
}

Status InputFile::read(std::uint64_t offset_bytes, std::span<std::byte> out) const {
  for (std::size_t done = 0; done < out.size();) {
    const ssize_t got = ::pread(handle_, out.data() + done, out.size() - done, static_cast<off_t>(offset_bytes + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error(path_, "cannot read");
    if (got == 0)
      return Error{ErrorCode::kIo, "file ends early", path_, static_cast<std::int64_t>(offset_bytes + done)};
    done += static_cast<std::size_t>(got);
  }
  return {};
}

Result<std::uint64_t> file_size_bytes(const std::filesystem::path& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return io_error(path, "cannot open");
  if (!S_ISREG(info.st_mode)) return Error{ErrorCode::kIo, "not a regular file", path.string()};
  return static_cast<std::uint64_t>(info.st_size);
}

Status read_range(const std::filesystem::path& path, std::uint64_t offset_bytes, std::span<std::byte> out) {
  ZC_ASSIGN(const InputFile file, InputFile::open(path));
  return file.read(offset_bytes, out);
}

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t limit_bytes) {
  ZC_ASSIGN(const InputFile file, InputFile::open(path, limit_bytes));
  std::vector<std::byte> bytes(file.size_bytes());
  ZC_TRY(file.read(0, bytes));
  return bytes;
}

Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  return write_file_parts(path, std::span(&bytes, 1));
}

Status write_file_parts(const std::filesystem::path& path, std::span<const std::span<const std::byte>> parts) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return write_bytes(path, 0, path, parts);  // a pipe or a device stays what it is; a folder cannot be opened so
  }
  // What a link leads to is replaced, not the link.
  std::filesystem::path target = path;
  for (int links = 0; links < 40 && std::filesystem::is_symlink(target, failure); ++links)
    target = target.parent_path() / std::filesystem::read_symlink(target, failure);
  std::filesystem::path temporary = target;
  temporary += ".tmp" + process_name();
  if (Status written = write_bytes(temporary, O_CREAT | O_TRUNC, path, parts); !written.ok()) {
    ::unlink(temporary.c_str());
    return written;
  }
  if (::rename(temporary.c_str(), target.c_str()) != 0) {
    Error error = io_error(path, "cannot rename into place");
    ::unlink(temporary.c_str());
    return error;
  }
  return {};
}

Status make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) return Error{ErrorCode::kIo, "cannot create the folder: " + failure.message(), folder.string()};
  return {};
}

}  // namespace zc
