// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/world_writer.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <string_view>
#include <utility>

#include "base/file.h"
#include "streamer/world_format/world_index.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

// All that a bake writes at the top of a world.
constexpr std::array<std::string_view, 5> kWorldEntries = {kWorldIndexName, "tileset.json", "bake.json", "bake.cache",
                                                           "zones"};

Error io_error(const fs::path& path, const std::string& what, const std::error_code& code) {
  return {ErrorCode::kIo, what + ": " + code.message(), path.string()};
}

// All that was written to the file system that `path` is on, in one go: thousands of files one by one take seconds.
Status flush_file_system(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool done = fd >= 0 && ::syncfs(fd) == 0;
  const std::error_code code(errno, std::generic_category());
  if (fd >= 0) ::close(fd);
  return done ? Status{} : io_error(path, "cannot write to the disk", code);
}

// The names in a directory. Not every file system can do it for one, so that a failure is none of ours.
void flush_names(const fs::path& directory) {
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

// Both names stay taken at every moment; not every file system can do it.
bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

// An old world goes as a whole: nothing of the user's may lie in it, an input or a replay's pictures, say.
Status check_replaceable(const fs::path& target, const fs::path& out) {
  std::error_code code;
  const fs::file_status status = fs::symlink_status(target, code);
  if (!fs::exists(status)) return {};
  if (!fs::is_directory(status)) return Error{ErrorCode::kArgument, "exists and is not a directory", out.string()};
  const bool is_empty = fs::is_empty(target, code);
  if (code) return io_error(out, "cannot read", code);
  if (!is_empty && !fs::is_regular_file(target / kWorldIndexName, code))
    return Error{ErrorCode::kArgument, "is a directory that contains something else than a world", out.string()};
  for (fs::directory_iterator entry(target, code), end; !code && entry != end; entry.increment(code))
    if (std::ranges::find(kWorldEntries, entry->path().filename().string()) == kWorldEntries.end())
      return Error{ErrorCode::kArgument, "contains something besides a world: " + entry->path().filename().string(),
                   out.string()};
  if (code) return io_error(out, "cannot read", code);
  return {};
}

}  // namespace

Result<WorldWriter> WorldWriter::open(const fs::path& out) {
  std::error_code code;
  fs::path target = fs::absolute(out, code).lexically_normal();
  if (code) return io_error(out, "cannot resolve", code);
  if (!target.has_filename()) target = target.parent_path();
  if (!target.has_filename()) return Error{ErrorCode::kArgument, "is not a place for a world", out.string()};
  ZC_TRY(check_replaceable(target, out));
  fs::create_directories(target.parent_path(), code);
  if (code) return io_error(target.parent_path(), "cannot create", code);
  fs::path beside = target.parent_path() / ".";
  beside += target.filename();
  beside += ".baking";
  ZC_ASSIGN(std::optional<FolderLock> lock, FolderLock::take(beside));
  if (!lock) return Error{ErrorCode::kIo, "another bake is writing this world", out.string()};
  WorldWriter writer(std::move(target), *std::move(lock));
  ZC_TRY(writer.remove_leftovers());
  // As it is now that nobody else writes it, and what a bake left behind may have come back.
  ZC_TRY(check_replaceable(writer.out_, out));
  fs::create_directory(writer.fresh(), code);
  if (code) return io_error(writer.fresh(), "cannot create", code);
  return writer;
}

WorldWriter::WorldWriter(fs::path out, FolderLock lock) : out_(std::move(out)), lock_(std::move(lock)) {}

WorldWriter::~WorldWriter() {
  if (!lock_.is_held()) return;  // moved from
  std::error_code ignored;
  fs::remove_all(fresh(), ignored);
}

Status WorldWriter::remove_leftovers() const {
  std::error_code code;
  if (fs::exists(old(), code) && !fs::exists(out_, code)) {
    fs::rename(old(), out_, code);
    if (code) return io_error(old(), "cannot put the old world back", code);
  }
  for (const fs::path& leftover : {old(), fresh()}) {
    fs::remove_all(leftover, code);
    if (code) return io_error(leftover, "cannot remove what an earlier bake left", code);
  }
  return {};
}

Status WorldWriter::make_directory(const std::string& relative) {
  std::error_code code;
  fs::create_directories(fresh() / relative, code);
  if (code) return io_error(fresh() / relative, "cannot create", code);
  return {};
}

Status WorldWriter::write(const std::string& relative, std::span<const std::byte> bytes) const {
  return write_file(fresh() / relative, bytes);
}

Status WorldWriter::write_text(const std::string& relative, std::string_view text) const {
  return write(relative, std::as_bytes(std::span(text.data(), text.size())));
}

Status WorldWriter::commit(bool may_exchange) {
  std::error_code code;
  ZC_TRY(flush_file_system(fresh()));  // before the name is: a name must not outlive what it stands for
  const bool replaces = fs::exists(out_, code);
  if (!replaces || !may_exchange || !exchange(fresh(), out_)) {
    if (replaces) fs::rename(out_, old(), code);
    if (code) return io_error(out_, "cannot rename away", code);
    fs::rename(fresh(), out_, code);
    if (code) {
      const Error error = io_error(out_, "cannot rename into place", code);
      if (replaces) fs::rename(old(), out_, code);
      return error;
    }
  }
  flush_names(out_.parent_path());
  flush_names(lock_.folder());
  // What is left beside is the old world. A failure to remove it is the next bake's to report.
  fs::remove_all(fresh(), code);
  fs::remove_all(old(), code);
  return {};
}

}  // namespace zc
