// SPDX-License-Identifier: GPL-3.0-or-later
// From triangles to the wide tree of a zone: the builders of this room, selectable so that they can be compared.
// Deterministic. Thread-safe: no state, one call a zone from any thread.
#pragma once

#include <span>

#include "baker/bvh/collapse.h"
#include "base/result.h"

namespace zc {

struct BvhBuildOptions {
  CollapseOptions collapse;
};

// Fails when there is no triangle, or more than a page can number. The depth is at most gpu::kPageMaxDepth.
Result<WideTree> build_wide_bvh(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options);

}  // namespace zc
