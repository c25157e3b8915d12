// SPDX-License-Identifier: Apache-2.0
// A text file that is written line by line and is there only when it is whole. Fails when the disk does. Threads: one.
#pragma once

#include <filesystem>
#include <fstream>

#include "base/result.h"

namespace zc {

class TextFile {
 public:
  static Result<TextFile> create(const std::filesystem::path& file);
  TextFile(TextFile&&) = default;
  TextFile& operator=(TextFile&&) = default;
  ~TextFile();  // without close(): nothing is left behind

  [[nodiscard]] std::ofstream& stream() { return stream_; }
  [[nodiscard]] Status status() const;
  Status close();

 private:
  TextFile() = default;
  std::filesystem::path file_, temporary_;
  std::ofstream stream_;
};

}  // namespace zc
