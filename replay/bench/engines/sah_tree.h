// SPDX-License-Identifier: Apache-2.0
// A plain binary BVH over all triangles at once, for the peers' layouts: binned SAH (Wald 2007) with a full sweep where
// few triangles are left. Deterministic. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "replay/bench/engines/trace_engine.h"

namespace zc::bench {

struct SahBox {
  std::array<float, 3> min = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::infinity()};
  std::array<float, 3> max = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity()};
};

struct SahNode {
  SahBox box;
  std::uint32_t first = 0;  // of the leaf's places in `order`, or of the two children, which stand together
  std::uint32_t count = 0;  // 0: inner
};

struct SahTree {
  std::vector<SahNode> nodes;        // node 0 is the root; children come after their parent
  std::vector<std::uint32_t> order;  // triangles, leaf by leaf
  std::uint32_t depth = 0;           // inner nodes on the longest path
};

struct SahOptions {
  std::uint32_t max_leaf = 4;
  float node_cost = 1;  // in triangle tests
};
// At least one triangle.
SahTree build_sah_tree(std::span<const BenchTriangle> triangles, const SahOptions& options);

}  // namespace zc::bench
