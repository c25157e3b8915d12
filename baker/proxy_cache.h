// SPDX-License-Identifier: GPL-3.0-or-later
// What simplification returned for what it was given, kept in the world from one bake to the next: a bake after a
// change simplifies anew only the zones that the change touches, and gives the bytes that a bake from nothing gives.
// Untrusted input: a file that is damaged, cut short or of another version is as good as none.
// Owns what it read and what was added. Threads: find() and add() from any.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "baker/simplify.h"

namespace zc {

inline constexpr const char* kProxyCacheName = "bake.cache";

using ProxyKey = std::array<std::uint64_t, 2>;

// Of all that the proxy of a leaf depends on: the bound, the grid, the zone's place, its detail and the materials in
// it.
ProxyKey leaf_key(const SimplifyContext& context, const Zone& zone);
// Of an inner zone: the same, and the keys of the proxies that it is made of and of the leaves it is measured against.
ProxyKey inner_key(const SimplifyContext& context, const Zone& zone, std::span<const ProxyKey> children,
                   std::span<const ProxyKey> leaves);

class ProxyCache {
 public:
  // material_count: proxies that name another material are damaged.
  void read(const std::filesystem::path& file, std::size_t material_count);
  // Nothing where it is not known; a proxy that holds nothing where simplification found none worth storing.
  std::optional<std::optional<Proxy>> find(const ProxyKey& key);
  void add(const ProxyKey& key, const std::optional<Proxy>& proxy);
  // What was found or added, and nothing else. The same for the same world.
  [[nodiscard]] std::vector<std::byte> encode() const;

  [[nodiscard]] std::uint64_t found() const { return found_; }
  [[nodiscard]] std::uint64_t added() const { return added_; }

 private:
  struct Entry {
    std::vector<std::byte> bytes;
    bool used = false;
  };
  mutable std::mutex mutex_;
  std::map<ProxyKey, Entry> entries_;
  std::size_t material_count_ = 0;
  std::uint64_t found_ = 0;
  std::uint64_t added_ = 0;
};

}  // namespace zc
