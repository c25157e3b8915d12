// SPDX-License-Identifier: Apache-2.0
// Our pages' trees without compression: the yardstick of what compression costs. The same nodes in the same order, with
// exact boxes in floats, and every triangle as three corners in floats (shaders/bench/plain_layout.glsl).
// Units: lattice steps from the scene's local origin. The pool is one that tracing may read. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace zc::bench {

enum class PlainNodes {
  kByPlane,  // for single rays
  kByChild,  // for packets
};

struct PlainTriangle {
  std::uint32_t page_word = 0;  // in the pool of pages
  std::uint32_t position = 0;   // in that page
};

struct PlainPool {
  std::vector<std::uint32_t> words;  // the root's node first
  std::uint32_t first_triangle = 0;  // hits number triangles from here on
  std::vector<PlainTriangle> triangles;
};

// pool: pages, and behind them from root_word on the top level over them.
PlainPool make_plain_pool(std::span<const std::uint32_t> pool, std::uint32_t root_word, PlainNodes form);

}  // namespace zc::bench
