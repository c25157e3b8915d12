// SPDX-License-Identifier: Apache-2.0
#include "replay/serve/served_world.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <iterator>
#include <utility>

#include "base/text.h"
#include "streamer/open_source.h"
#include "streamer/source/index_file.h"
#include "streamer/source/source.h"

namespace zc {
namespace {

// Takes a number of at most ten digits off the front.
bool take_number(std::string_view& text) {
  std::size_t digits = 0;
  while (digits < text.size() && text[digits] >= '0' && text[digits] <= '9') ++digits;
  if (digits == 0 || digits > 10) return false;
  text.remove_prefix(digits);
  return true;
}

const char* type_of(std::string_view name) {
  if (name.ends_with(".glb")) return "model/gltf-binary";
  if (name.ends_with(".json")) return "application/json";
  if (name.ends_with(".3tz")) return "application/vnd.maxar.archive.3tz+zip";
  return "application/octet-stream";
}

// Folder by folder, none of them nor the file a link: what lies elsewhere is not for others to read. The name has no
// "..". Negative when there is no such file.
int open_beneath(const std::filesystem::path& folder, const std::filesystem::path& name) {
  int at = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);  // may be a link: whoever serves it named it
  for (auto part = name.begin(); at >= 0 && part != name.end(); ++part) {
    const bool last = std::next(part) == name.end();
    const int flags = last ? O_RDONLY | O_NONBLOCK : O_PATH | O_DIRECTORY;
    const int next = ::openat(at, part->c_str(), flags | O_NOFOLLOW | O_CLOEXEC);
    ::close(at);
    at = next;
  }
  return at;
}

}  // namespace

bool names_world_file(std::string_view name) {
  if (name == kWorldIndexName || name == "tileset.json" || name == "bake.json") return true;
  if (!take(name, "zones/") || !take_number(name) || !take(name, "/") || !take_number(name) || !take(name, "_") ||
      !take_number(name))
    return false;
  (void)take(name, ".detail");
  return name == ".glb" || name == ".zbvh";
}

ServedFile::ServedFile(ServedFile&& other) noexcept
    : handle_(std::exchange(other.handle_, -1)),
      bytes_(other.bytes_),
      etag_(std::move(other.etag_)),
      type_(other.type_) {}

ServedFile::~ServedFile() {
  if (handle_ >= 0) ::close(handle_);
}

std::size_t ServedFile::read(std::uint64_t offset, std::span<char> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(handle_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

Result<ServedWorld> ServedWorld::open(const std::filesystem::path& place) {
  if (is_url(place.native())) return Error{ErrorCode::kArgument, "is served already", place.string()};
  ZC_ASSIGN(const std::unique_ptr<Source> source, open_source(place));  // a folder or an archive, and nothing else
  ZC_ASSIGN([[maybe_unused]] const WorldIndex index, read_world_index(*source, place));
  std::error_code failure;
  const bool folder = std::filesystem::is_directory(place, failure);
  ServedWorld world(place, folder, folder ? std::string(kWorldIndexName) : place.filename().string());
  if (!world.find(world.first_name()))
    return Error{ErrorCode::kUnsupported, "is a link, and links in a world are not served; put the file in its place",
                 (place / world.first_name()).string()};
  return world;
}

std::optional<ServedFile> ServedWorld::find(std::string_view name) const {
  if (folder_ ? !names_world_file(name) : name != first_name_) return std::nullopt;
  const int handle = folder_ ? open_beneath(place_, name) : ::open(place_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (handle < 0) return std::nullopt;
  struct stat status {};
  if (::fstat(handle, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(handle);
    return std::nullopt;
  }
  std::array<char, 96> etag{};
  std::snprintf(etag.data(), etag.size(), "\"%jx-%jx-%jx%09lx\"", static_cast<std::uintmax_t>(status.st_ino),
                static_cast<std::uintmax_t>(status.st_size), static_cast<std::uintmax_t>(status.st_mtim.tv_sec),
                static_cast<unsigned long>(status.st_mtim.tv_nsec));
  return ServedFile(handle, static_cast<std::uint64_t>(status.st_size), etag.data(), type_of(name));
}

}  // namespace zc
