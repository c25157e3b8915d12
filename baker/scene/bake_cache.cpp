// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/scene/bake_cache.h"

#include <cstring>
#include <utility>

#include "base/file.h"

namespace zc {
namespace {

// One more whenever this format changes.
constexpr std::uint32_t kVersion = 3;
constexpr std::array<char, 4> kMagic = {'Z', 'P', 'C', '1'};
constexpr std::uint64_t kBytesLimit = std::uint64_t{1} << 34U;

struct FileHeader {
  std::array<char, 4> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint64_t xxh3 = 0;  // of all that follows
};

struct EntryPlace {
  CacheKey key = {};
  std::uint64_t bytes = 0;
};

}  // namespace

void BakeCache::read(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex_);
  const Result<std::vector<std::byte>> bytes = read_file(file, kBytesLimit);
  FileHeader header;
  if (!bytes || bytes->size() < sizeof header) return;
  std::memcpy(&header, bytes->data(), sizeof header);
  std::span<const std::byte> rest = std::span(*bytes).subspan(sizeof header);
  if (header.magic != kMagic || header.version != kVersion || header.xxh3 != XXH3_64bits(rest.data(), rest.size()))
    return;
  for (EntryPlace place; rest.size() >= sizeof place;) {
    std::memcpy(&place, rest.data(), sizeof place);
    rest = rest.subspan(sizeof place);
    if (place.bytes > rest.size()) return;
    const auto entry = rest.first(place.bytes);
    entries_[place.key].bytes.assign(entry.begin(), entry.end());
    rest = rest.subspan(place.bytes);
  }
}

std::optional<std::vector<std::byte>> BakeCache::find(const CacheKey& key) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return std::nullopt;
  entry->second.used = true;
  return entry->second.bytes;
}

void BakeCache::add(const CacheKey& key, std::vector<std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  entries_[key] = {std::move(bytes), true};
}

std::vector<std::byte> BakeCache::encode() const {
  const std::lock_guard lock(mutex_);
  FileHeader header;
  std::vector<std::byte> out(sizeof header);
  for (const auto& [key, entry] : entries_) {
    if (!entry.used) continue;
    const EntryPlace place = {key, entry.bytes.size()};
    const auto bytes = std::as_bytes(std::span(&place, 1));
    out.insert(out.end(), bytes.begin(), bytes.end());
    out.insert(out.end(), entry.bytes.begin(), entry.bytes.end());
  }
  header.xxh3 = XXH3_64bits(out.data() + sizeof header, out.size() - sizeof header);
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

}  // namespace zc
