// SPDX-License-Identifier: GPL-3.0-or-later
// Proxies in the bake's cache: what simplification returned for what it was given.
// Threads: find() and add() from any.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "baker/proxy/simplify.h"
#include "baker/scene/bake_cache.h"

namespace zc {

// Of all that the proxy of a leaf depends on: the bound, the grid, the zone's place, its detail and the materials in
// it.
CacheKey leaf_key(const SimplifyContext& context, const Zone& zone);
// Of an inner zone: the same, and the keys of the proxies that it is made of and of the leaves it is measured against.
CacheKey inner_key(const SimplifyContext& context, const Zone& zone, std::span<const CacheKey> children,
                   std::span<const CacheKey> leaves);

class ProxyCache {
 public:
  // material_count: proxies that name another material are damaged. Borrows the store.
  ProxyCache(BakeCache& store, std::size_t material_count) : store_(store), material_count_(material_count) {}
  // Nothing where it is not known; a proxy that contains nothing where simplification found none worth storing.
  std::optional<std::optional<Proxy>> find(const CacheKey& key);
  void add(const CacheKey& key, const std::optional<Proxy>& proxy);

  [[nodiscard]] std::uint64_t found() const { return found_; }
  [[nodiscard]] std::uint64_t added() const { return added_; }

 private:
  BakeCache& store_;
  std::size_t material_count_ = 0;
  std::atomic<std::uint64_t> found_ = 0;
  std::atomic<std::uint64_t> added_ = 0;
};

}  // namespace zc
