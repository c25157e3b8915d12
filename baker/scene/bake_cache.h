// SPDX-License-Identifier: GPL-3.0-or-later
// What stages of a bake returned for what they were given, kept in the world from one bake to the next: a bake after a
// change does anew only what the change touches, and gives the bytes that a bake from nothing gives.
// Untrusted input: a file that is damaged, cut short or of another version is as good as none, and whoever finds an
// entry checks it. Owns what it read and what was added. Threads: find() and add() from any.
#pragma once

#include <xxhash.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

namespace zc {

inline constexpr const char* kBakeCacheName = "bake.cache";

// A hash of all that an entry depends on.
using CacheKey = std::array<std::uint64_t, 2>;

class CacheKeyHasher {
 public:
  CacheKeyHasher() { XXH3_128bits_reset(state_.get()); }
  template <class T>
  requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T> CacheKeyHasher& add(
      const T& value) {
    XXH3_128bits_update(state_.get(), &value, sizeof value);
    return *this;
  }
  template <class T>
  requires std::has_unique_object_representations_v<T> CacheKeyHasher& add(std::span<const T> values) {
    add(std::uint64_t{values.size()});
    if (!values.empty()) XXH3_128bits_update(state_.get(), values.data(), values.size_bytes());
    return *this;
  }
  [[nodiscard]] CacheKey key() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
    return {hash.high64, hash.low64};
  }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};

class BakeCache {
 public:
  void read(const std::filesystem::path& file);
  // Nothing where the key is not known. What was found stays in the cache until something is added in its place.
  std::optional<std::vector<std::byte>> find(const CacheKey& key);
  void add(const CacheKey& key, std::vector<std::byte> bytes);
  // What was found or added, and nothing else. The same for the same world.
  [[nodiscard]] std::vector<std::byte> encode() const;

 private:
  struct Entry {
    std::vector<std::byte> bytes;
    bool used = false;
  };
  mutable std::mutex mutex_;
  std::map<CacheKey, Entry> entries_;
};

}  // namespace zc
