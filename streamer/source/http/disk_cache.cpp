// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/disk_cache.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <system_error>

#include "base/file.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".zccache";
constexpr std::size_t kNameDigits = 32;

struct EntryHeader {  // key and bytes follow
  std::array<char, 8> magic = {'Z', 'C', 'C', 'A', 'C', 'H', 'E', '1'};
  std::uint64_t key_bytes = 0;
  std::uint64_t bytes = 0;
  std::uint64_t xxh3 = 0;  // of key and bytes
};
static_assert(sizeof(EntryHeader) == 32);

// Of another process's write as well, which only a crash leaves behind.
bool ours(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.size() >= kNameDigits && name.find_first_not_of("0123456789abcdef") == kNameDigits &&
         name.compare(kNameDigits, std::strlen(kExtension), kExtension) == 0;
}

struct Entry {
  fs::path path;
  fs::file_time_type used;
  std::uint64_t bytes = 0;
};

std::vector<Entry> list(const fs::path& folder) {
  std::vector<Entry> entries;
  std::error_code failure;
  for (fs::directory_iterator at(folder, failure), end; !failure && at != end; at.increment(failure)) {
    if (!ours(at->path())) continue;
    std::error_code gone;
    Entry entry{at->path(), at->last_write_time(gone), 0};
    if (!gone) entry.bytes = at->file_size(gone);
    if (!gone) entries.push_back(std::move(entry));
  }
  return entries;
}

std::uint64_t sum(const std::vector<Entry>& entries) {
  std::uint64_t bytes = 0;
  for (const Entry& entry : entries) bytes += entry.bytes;
  return bytes;
}

}  // namespace

Result<std::unique_ptr<DiskCache>> DiskCache::open(const fs::path& folder, std::uint64_t limit_bytes) {
  ZC_TRY(make_folder(folder));
  return std::unique_ptr<DiskCache>(new DiskCache(folder, limit_bytes));
}

DiskCache::DiskCache(fs::path folder, std::uint64_t limit_bytes)
    : folder_(std::move(folder)), limit_bytes_(limit_bytes) {
  const std::lock_guard lock(mutex_);
  held_bytes_ = sum(list(folder_));
  if (held_bytes_ > limit_bytes_) shrink(0);
}

fs::path DiskCache::place_of(const std::string& key) const {
  const XXH128_hash_t hash = XXH3_128bits(key.data(), key.size());
  XXH128_canonical_t digest;
  XXH128_canonicalFromHash(&digest, hash);
  std::string name;
  for (const unsigned char c : digest.digest) {
    name += "0123456789abcdef"[c >> 4U];
    name += "0123456789abcdef"[c & 15U];
  }
  return folder_ / (name + kExtension);
}

bool DiskCache::has(const std::string& key) const {
  std::error_code failure;
  return fs::exists(place_of(key), failure);
}

std::optional<std::vector<std::byte>> DiskCache::get(const std::string& key, std::uint64_t limit_bytes) {
  const fs::path place = place_of(key);
  const auto file = InputFile::open(place);
  EntryHeader header;
  const std::uint64_t front = sizeof header + key.size();
  std::vector<std::byte> head(front);
  if (file && file->size_bytes() >= front && file->read(0, head).ok()) {
    std::memcpy(&header, head.data(), sizeof header);
    const bool sound = header.magic == EntryHeader{}.magic && header.key_bytes == key.size() &&
                       header.bytes == file->size_bytes() - front &&
                       std::memcmp(head.data() + sizeof header, key.data(), key.size()) == 0;
    if (sound && header.bytes > limit_bytes) return std::nullopt;
    if (sound) {
      std::vector<std::byte> bytes(header.bytes);
      if (file->read(front, bytes).ok() &&
          XXH3_64bits_withSeed(bytes.data(), bytes.size(), XXH3_64bits(key.data(), key.size())) == header.xxh3) {
        std::error_code failure;
        fs::last_write_time(place, fs::file_time_type::clock::now(), failure);
        return bytes;
      }
    }
  }
  if (file_size_bytes(place).ok()) discard(place);  // another process may have removed it meanwhile
  return std::nullopt;
}

void DiskCache::put(const std::string& key, std::span<const std::byte> bytes) {
  EntryHeader header;
  header.key_bytes = key.size();
  header.bytes = bytes.size();
  header.xxh3 = XXH3_64bits_withSeed(bytes.data(), bytes.size(), XXH3_64bits(key.data(), key.size()));
  const std::uint64_t all = sizeof header + key.size() + bytes.size();
  if (all > limit_bytes_) return;
  const std::array<std::span<const std::byte>, 3> parts = {std::as_bytes(std::span(&header, 1)),
                                                           std::as_bytes(std::span(key.data(), key.size())), bytes};
  const fs::path place = place_of(key);
  const std::lock_guard lock(mutex_);  // also because two writes of one entry would share a temporary name
  if (held_bytes_ + all > limit_bytes_) shrink(all);
  if (write_file_parts(place, parts).ok()) held_bytes_ += all;
}

void DiskCache::remove(const std::string& key) {
  std::error_code failure;
  fs::remove(place_of(key), failure);
}

std::uint64_t DiskCache::damaged() const {
  const std::lock_guard lock(mutex_);
  return damaged_;
}

void DiskCache::discard(const fs::path& place) {
  std::error_code failure;
  fs::remove(place, failure);
  const std::lock_guard lock(mutex_);
  ++damaged_;
}

// To nine tenths of the limit, with what is coming: the folder is not listed for every new entry.
void DiskCache::shrink(std::uint64_t coming) {
  const std::uint64_t target = limit_bytes_ / 10 * 9;
  std::vector<Entry> entries = list(folder_);
  std::ranges::sort(
      entries, [](const Entry& a, const Entry& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
  held_bytes_ = sum(entries);
  for (const Entry& entry : entries) {
    if (held_bytes_ + coming <= target) break;
    std::error_code failure;
    fs::remove(entry.path, failure);
    if (!failure) held_bytes_ -= entry.bytes;
  }
}

}  // namespace zc
