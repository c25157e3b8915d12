// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a cut world into the nodes that are stored: details, leaf proxies, and those inner proxies that pay; in the
// index's order (breadth first, siblings contiguous). Deterministic at any thread count.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "baker/cut/cut.h"
#include "baker/proxy/proxy_cache.h"
#include "baker/proxy/simplify.h"
#include "base/result.h"

namespace zc {

struct ProxyNode {
  std::int32_t parent = -1;
  std::uint32_t first_child = 0;
  std::uint32_t child_count = 0;
  std::uint32_t depth = 0;
  std::uint32_t cell_x = 0;
  std::uint32_t cell_y = 0;
  bool is_detail = false;
  Proxy proxy;
};

struct ProxyTree {
  std::vector<ProxyNode> nodes;
  std::uint64_t coarse_zones = 0;        // leaves whose rounding alone moves points by more than the error bound
  std::uint64_t lost_triangles = 0;      // of the details, in the rounding to their zones' steps
  std::uint64_t bounded_zones = 0;       // whose simplification ended at its bound of work
  std::uint64_t work = 0;                // boxes and triangles looked at
  std::uint64_t left_out = 0;            // inner zones whose proxy saves too little
  std::uint64_t left_out_triangles = 0;  // that these would have at least
};

// `done` is called once per zone, from any thread. Fails when nothing survives.
// What the cache knows is taken from it, what it does not is added.
Result<ProxyTree> build_proxies(ZoneTree&& tree, const SimplifyContext& context, ProxyCache& cache,
                                const std::function<void()>& done);

}  // namespace zc
