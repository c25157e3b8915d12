// SPDX-License-Identifier: GPL-3.0-or-later
// From triangles to the wide tree of a zone: the builders of this folder, selectable so that they can be compared, and
// `auto`, which keeps the candidate that costs least to trace (simulate.h), bytes considered: binned SAH with
// reinsertion, without where that comes out too deep, and SBVH. Deterministic. Thread-safe: no state, one call a zone
// from any thread.
#pragma once

#include <span>
#include <string_view>

#include "baker/bvh/collapse.h"
#include "baker/bvh/reinsertion.h"
#include "baker/bvh/sbvh.h"
#include "base/result.h"

namespace zc {

enum class BvhMethod : std::uint8_t { kAuto, kBinned, kSweep, kSbvh, kBinnedReinsert, kSweepReinsert, kSbvhReinsert };

// All of them, with the names that the command line uses; `auto` first.
struct BvhMethodName {
  BvhMethod method;
  std::string_view name;
};
std::span<const BvhMethodName> bvh_methods();

struct BvhBuildOptions {
  BvhMethod method = BvhMethod::kAuto;
  CollapseOptions collapse;
  SbvhOptions sbvh;
  ReinsertionOptions reinsertion;
  // `auto`: a candidate whose page is one byte a triangle larger must cost so much less, relatively.
  double byte_weight = 0.005;
  // `auto`: candidates whose page takes more bytes a triangle lose to those that stay within.
  double bytes_per_triangle_max = 16;
  // `auto`: deeper candidates lose as well. With the top level over a few hundred zones they outgrow the stack of
  // packets, and one deep page has all rays of a world traced one by one.
  std::uint32_t depth_preferred = 10;
};

// Fails when there is no triangle, or more than a page can number. The depth is at most gpu::kPageMaxDepth.
Result<WideTree> build_wide_bvh(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options);

}  // namespace zc
