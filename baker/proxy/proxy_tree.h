// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a cut world into the nodes that are stored: details, leaf proxies, and those inner proxies that pay; in the
// index's order (breadth first, siblings contiguous). Deterministic at any thread count.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baker/cut/cut.h"
#include "baker/proxy/simplify.h"
#include "baker/scene/bake_cache.h"
#include "baker/scene/bake_context.h"
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

struct ProxyInput {
  ZoneTree tree;
  double step_m = 0;
  double error_m = 0;  // bound of leaf proxies
  std::uint32_t leaf_triangles = 0;
  bool atlases = false;  // textured zones have one
  BakeCache& cache;      // proxies that it has are taken from it, others are added
  // Of the whole city:
  std::span<const Material> materials;
};

struct ProxyTree {
  std::vector<ProxyNode> nodes;
  std::vector<ImportCount> notes;
  std::uint64_t reused = 0;              // proxies that the cache had
  std::uint64_t built = 0;               // the others
  std::uint64_t work = 0;                // boxes and triangles visited for these
  std::uint64_t left_out = 0;            // inner zones whose proxy saves too little
  std::uint64_t left_out_triangles = 0;  // that these would have at least
};

// Fails when no triangle survives.
Result<ProxyTree> build_proxies(ProxyInput&& input, BakeContext& context);

}  // namespace zc
