// SPDX-License-Identifier: Apache-2.0
#include "base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace zc {
namespace {

constexpr int kTries = 1000;

Error io_error(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kIo, std::string(what) + ": " + std::strerror(errno), path.string()};
}

// Who had the file before may have removed it between our opening and our locking: then it keeps nobody out.
bool is_still_there(int fd, const std::filesystem::path& file) {
  struct stat ours {};
  struct stat named {};
  return ::fstat(fd, &ours) == 0 && ::stat(file.c_str(), &named) == 0 && ours.st_dev == named.st_dev &&
         ours.st_ino == named.st_ino;
}

}  // namespace

Result<std::optional<FolderLock>> FolderLock::take(const std::filesystem::path& folder, const std::string& lock_name) {
  const std::filesystem::path file = folder / lock_name;
  for (int tries = 0; tries < kTries; ++tries) {
    if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) return io_error(folder, "cannot create");
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0 && errno == ENOENT) continue;  // its owner has just removed the folder
    if (fd < 0) return io_error(file, "cannot create");
    FolderLock lock(folder, file, fd);
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      const bool is_taken = errno == EWOULDBLOCK;
      const Error error = io_error(file, "cannot lock");
      ::close(std::exchange(lock.fd_, -1));
      if (is_taken) return std::optional<FolderLock>();
      return error;
    }
    if (is_still_there(fd, file)) return std::optional<FolderLock>(std::move(lock));
    ::close(std::exchange(lock.fd_, -1));
  }
  return std::optional<FolderLock>();
}

FolderLock::FolderLock(std::filesystem::path folder, std::filesystem::path file, int fd)
    : folder_(std::move(folder)), file_(std::move(file)), fd_(fd) {}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : folder_(std::move(other.folder_)), file_(std::move(other.file_)), fd_(std::exchange(other.fd_, -1)) {}

FolderLock::~FolderLock() {
  if (fd_ < 0) return;
  ::unlink(file_.c_str());  // while it is locked: nobody else takes what is about to go
  ::rmdir(folder_.c_str());
  ::close(fd_);
}

}  // namespace zc
