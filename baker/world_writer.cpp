// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/world_writer.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
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

fs::path sibling(const fs::path& path, const char* kind) {
  fs::path name(".");
  name += path.filename();
  name += ".";
  name += kind;
  name += "-";
  name += std::to_string(::getpid());
  return path.parent_path() / name;
}

// Both names stay taken at every moment; not every file system can do it.
bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

}  // namespace

Result<WorldWriter> WorldWriter::open(const fs::path& out) {
  std::error_code code;
  fs::path target = fs::absolute(out, code).lexically_normal();
  if (code) return io_error(out, "cannot resolve", code);
  if (!target.has_filename()) target = target.parent_path();
  if (!target.has_filename()) return Error{ErrorCode::kArgument, "is not a place for a world", out.string()};
  const fs::file_status status = fs::symlink_status(target, code);
  if (fs::exists(status)) {
    if (!fs::is_directory(status)) return Error{ErrorCode::kArgument, "exists and is not a directory", out.string()};
    const bool is_empty = fs::is_empty(target, code);
    if (code) return io_error(out, "cannot read", code);
    if (!is_empty && !fs::is_regular_file(target / kWorldIndexName, code))
      return Error{ErrorCode::kArgument, "is a directory that holds something else than a world", out.string()};
    // The old world goes as a whole: nothing of the user's may lie in it, an input or a replay's pictures, say.
    for (fs::directory_iterator entry(target, code), end; !code && entry != end; entry.increment(code))
      if (std::ranges::find(kWorldEntries, entry->path().filename().string()) == kWorldEntries.end())
        return Error{ErrorCode::kArgument, "holds something besides a world: " + entry->path().filename().string(),
                     out.string()};
    if (code) return io_error(out, "cannot read", code);
  }
  fs::create_directories(target.parent_path(), code);
  if (code) return io_error(target.parent_path(), "cannot create", code);
  fs::path temporary = sibling(target, "baking");
  fs::remove_all(temporary, code);  // of a process that had our number and was killed
  fs::create_directory(temporary, code);
  if (code) return io_error(temporary, "cannot create", code);
  return WorldWriter(std::move(target), std::move(temporary));
}

WorldWriter::WorldWriter(fs::path out, fs::path temporary) : out_(std::move(out)), temporary_(std::move(temporary)) {}

WorldWriter::WorldWriter(WorldWriter&& other) noexcept
    : out_(std::move(other.out_)), temporary_(std::exchange(other.temporary_, {})) {}

WorldWriter::~WorldWriter() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

Status WorldWriter::make_directory(const std::string& relative) {
  std::error_code code;
  fs::create_directories(temporary_ / relative, code);
  if (code) return io_error(temporary_ / relative, "cannot create", code);
  return {};
}

Status WorldWriter::write(const std::string& relative, std::span<const std::byte> bytes) const {
  return write_file(temporary_ / relative, bytes);
}

Status WorldWriter::write_text(const std::string& relative, std::string_view text) const {
  return write(relative, std::as_bytes(std::span(text.data(), text.size())));
}

Status WorldWriter::commit() {
  std::error_code code;
  if (!fs::exists(out_, code)) {
    fs::rename(temporary_, out_, code);
    if (code) return io_error(out_, "cannot rename into place", code);
    temporary_.clear();
    return {};
  }
  if (!exchange(temporary_, out_)) {
    const fs::path old = sibling(out_, "old");
    fs::remove_all(old, code);
    fs::rename(out_, old, code);
    if (code) return io_error(out_, "cannot rename away", code);
    fs::rename(temporary_, out_, code);
    if (code) {
      const Error error = io_error(out_, "cannot rename into place", code);
      fs::rename(old, out_, code);
      return error;
    }
    temporary_ = old;
  }
  // Here the temporary name holds the old world.
  fs::remove_all(temporary_, code);
  temporary_.clear();
  return {};
}

}  // namespace zc
