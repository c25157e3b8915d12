// SPDX-License-Identifier: Apache-2.0
#include "replay/files/text_file.h"

#include <cerrno>
#include <cstring>

namespace zc {

Result<TextFile> TextFile::create(const std::filesystem::path& file) {
  TextFile text;
  text.file_ = file;
  text.temporary_ = file;
  text.temporary_ += ".tmp";
  errno = 0;  // the stream reports no cause, the call beneath it does
  text.stream_.open(text.temporary_, std::ios::trunc);
  ZC_TRY(text.status());
  return text;
}

TextFile::~TextFile() {
  if (!stream_.is_open()) return;
  stream_.close();
  std::error_code ignored;  // the temporary file is all that could stay, and a failure already has its own message
  std::filesystem::remove(temporary_, ignored);
}

Status TextFile::status() const {
  if (stream_) return {};
  const std::string cause = errno != 0 ? ": " + std::string(std::strerror(errno)) : "";
  return Error{ErrorCode::kIo, "cannot write" + cause, file_.string()};
}

Status TextFile::close() {
  errno = 0;
  stream_.close();
  const Status written = status();
  std::error_code failure;
  std::error_code ignored;
  if (!written.ok()) {
    std::filesystem::remove(temporary_, ignored);
    return written;
  }
  std::filesystem::rename(temporary_, file_, failure);
  if (failure) {
    std::filesystem::remove(temporary_, ignored);
    return Error{ErrorCode::kIo, "cannot rename into place: " + failure.message(), file_.string()};
  }
  return {};
}

}  // namespace zc
