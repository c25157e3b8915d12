// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/source.h"

#include <xxhash.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "base/file.h"
#include "base/text.h"

namespace zc {
namespace {

class FileInMemory final : public SourceFile {
 public:
  FileInMemory(std::vector<std::byte> bytes, std::string name) : bytes_(std::move(bytes)), name_(std::move(name)) {}
  [[nodiscard]] std::uint64_t size_bytes() const override { return bytes_.size(); }
  Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const override {
    if (offset_bytes > bytes_.size() || out.size() > bytes_.size() - offset_bytes)
      return Error{ErrorCode::kFormat, "ends early", name_};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset_bytes), out.size(), out.begin());
    return {};
  }

 private:
  std::vector<std::byte> bytes_;
  std::string name_;
};

class FileOnDisk final : public SourceFile {
 public:
  explicit FileOnDisk(InputFile file) : file_(std::move(file)) {}
  [[nodiscard]] std::uint64_t size_bytes() const override { return file_.size_bytes(); }
  Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const override {
    return file_.read(offset_bytes, out);
  }

 private:
  InputFile file_;
};

class DirectorySource final : public Source {
 public:
  explicit DirectorySource(std::filesystem::path dir) : dir_(std::move(dir)) {}

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    ZC_ASSIGN(const std::filesystem::path path, locate(name));
    ZC_ASSIGN(const InputFile file, InputFile::open(path));
    if (file.size_bytes() != bytes)
      return Error{ErrorCode::kFormat,
                   "is " + std::to_string(file.size_bytes()) + " bytes, the index says " + std::to_string(bytes),
                   path.string()};
    std::vector<std::byte> out(bytes);
    ZC_TRY(file.read(0, out));
    return out;
  }

  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const std::filesystem::path path, locate(name));
    return read_file(path, limit_bytes);
  }

  Result<std::unique_ptr<SourceFile>> open(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const std::filesystem::path path, locate(name));
    ZC_ASSIGN(InputFile file, InputFile::open(path, limit_bytes));
    return std::unique_ptr<SourceFile>(std::make_unique<FileOnDisk>(std::move(file)));
  }

  [[nodiscard]] SourceCosts costs() const override { return {.whole_files = false}; }

 private:
  [[nodiscard]] Result<std::filesystem::path> locate(const std::string& name) const {
    ZC_TRY(check_name(name));
    return dir_ / name;
  }

  std::filesystem::path dir_;
};

class ReadWhenWaitedFor final : public AsyncRead {
 public:
  ReadWhenWaitedFor(Source& source, std::vector<WantedFile> files)
      : source_(source), files_(std::move(files)), bytes_(files_.size()) {}

  Result<std::span<const std::byte>> wait(std::size_t i) override {
    ZC_ASSIGN(bytes_[i], source_.read(files_[i].name, files_[i].bytes));
    ZC_TRY(check_wanted(bytes_[i], files_[i]));
    return std::span<const std::byte>(bytes_[i]);
  }

 private:
  Source& source_;
  const std::vector<WantedFile> files_;
  std::vector<std::vector<std::byte>> bytes_;
};

}  // namespace

Status check_name(const std::string& name) {
  const std::filesystem::path relative(name);
  if (name.empty() || relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end())
    return Error{ErrorCode::kArgument, "name leaves the world", name};
  return {};
}

Status check_wanted(std::span<const std::byte> bytes, const WantedFile& file) {
  if (bytes.size() != file.bytes)
    return Error{ErrorCode::kIo, "the source returned another size than asked for", file.name};
  if (XXH3_64bits(bytes.data(), bytes.size()) != file.xxh3)
    return Error{ErrorCode::kFormat, "hash differs from the index: the file is damaged", file.name};
  return {};
}

std::unique_ptr<AsyncRead> Source::begin(std::vector<WantedFile> files) {
  return std::make_unique<ReadWhenWaitedFor>(*this, std::move(files));
}

Result<std::unique_ptr<SourceFile>> Source::open(const std::string& name, std::uint64_t limit_bytes) {
  ZC_ASSIGN(std::vector<std::byte> bytes, read_all(name, limit_bytes));
  return std::unique_ptr<SourceFile>(std::make_unique<FileInMemory>(std::move(bytes), name));
}

bool is_url(std::string_view place) {
  const std::string start = lower(place.substr(0, 8));
  return start.starts_with("http://") || start.starts_with("https://");
}

Result<std::unique_ptr<Source>> open_directory_source(const std::filesystem::path& dir) {
  std::error_code code;
  if (!std::filesystem::is_directory(dir, code)) return Error{ErrorCode::kIo, "not a directory", dir.string()};
  return std::unique_ptr<Source>(std::make_unique<DirectorySource>(dir));
}

}  // namespace zc
