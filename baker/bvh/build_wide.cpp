// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/build_wide.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "baker/bvh/binned_sah.h"
#include "baker/bvh/simulate.h"
#include "baker/bvh/sweep_sah.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr std::array kMethods = {
    BvhMethodName{BvhMethod::kAuto, "auto"},
    BvhMethodName{BvhMethod::kBinned, "binned"},
    BvhMethodName{BvhMethod::kSweep, "sweep"},
    BvhMethodName{BvhMethod::kSbvh, "sbvh"},
    BvhMethodName{BvhMethod::kBinnedReinsert, "binned+reinsert"},
    BvhMethodName{BvhMethod::kSweepReinsert, "sweep+reinsert"},
    BvhMethodName{BvhMethod::kSbvhReinsert, "sbvh+reinsert"},
};

WideTree collapse_within_depth(const BinaryTree& binary, const CollapseOptions& options) {
  WideTree tree = collapse(binary, options);
  if (tree.depth > gpu::kPageMaxDepth) {
    CollapseOptions by_levels = options;
    by_levels.by_levels = true;
    tree = collapse(binary, by_levels);
  }
  // Three binary levels a node; one level more where a leaf did not fit its node.
  static_assert((kBinaryDepthMax - 1 + 2) / 3 + 1 <= gpu::kPageMaxDepth);
  ZC_CHECK(tree.depth <= gpu::kPageMaxDepth);
  return tree;
}

BvhMethod without_reinsertion(BvhMethod method) {
  switch (method) {
    case BvhMethod::kBinnedReinsert:
      return BvhMethod::kBinned;
    case BvhMethod::kSweepReinsert:
      return BvhMethod::kSweep;
    case BvhMethod::kSbvhReinsert:
      return BvhMethod::kSbvh;
    default:
      return method;
  }
}

BinaryTree build_binary(std::span<const BvhTriangle> triangles, BvhMethod method, const BvhBuildOptions& options) {
  if (method == BvhMethod::kSbvh) return build_sbvh(triangles, options.sbvh);
  std::vector<BvhReference> references(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) references[i] = {box_of(triangles[i]), i};
  return method == BvhMethod::kBinned ? build_binned_sah(references) : build_sweep_sah(references);
}

// About the bytes that a page takes for nodes and triangles.
double estimated_page_bytes(const WideTree& tree) {
  // A reference is a word and, with a cluster's header, about half a vertex of six bytes.
  return 80.0 * static_cast<double>(tree.nodes.size()) + 8.0 * static_cast<double>(tree.references.size());
}

// Keeps the candidate that scores least.
class Cheapest {
 public:
  Cheapest(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options)
      : triangles_(triangles), options_(options), rays_(make_sample_rays(triangles)) {}

  void consider(WideTree&& tree) {
    const double bytes = estimated_page_bytes(tree) / static_cast<double>(triangles_.size());
    double score = simulated_cost(tree, triangles_, rays_) * (1 + options_.byte_weight * bytes);
    if (bytes > options_.bytes_per_triangle_max)
      score *= 1e3 * bytes;  // behind all that stay within; then the smallest
    if (tree.depth > options_.depth_preferred) score *= 1e6 * tree.depth;
    if (score >= best_score_) return;
    best_score_ = score;
    best_ = std::move(tree);
  }
  WideTree take() && { return std::move(best_); }

 private:
  std::span<const BvhTriangle> triangles_;
  const BvhBuildOptions& options_;
  std::vector<SampleRay> rays_;
  WideTree best_;
  double best_score_ = std::numeric_limits<double>::infinity();
};

WideTree build_cheapest(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options) {
  Cheapest cheapest(triangles, options);
  const BinaryTree plain = build_binary(triangles, BvhMethod::kBinned, options);
  BinaryTree optimized = plain;
  optimize_by_reinsertion(optimized, options.reinsertion);
  WideTree tree = collapse_within_depth(optimized, options.collapse);
  const bool deep = tree.depth > options.depth_preferred;
  cheapest.consider(std::move(tree));
  if (deep) cheapest.consider(collapse_within_depth(plain, options.collapse));
  cheapest.consider(collapse_within_depth(build_binary(triangles, BvhMethod::kSbvh, options), options.collapse));
  return std::move(cheapest).take();
}

}  // namespace

std::span<const BvhMethodName> bvh_methods() { return kMethods; }

Result<WideTree> build_wide_bvh(std::span<const BvhTriangle> triangles, const BvhBuildOptions& options) {
  if (triangles.empty()) return Error{ErrorCode::kFormat, "a zone without triangles has no BVH"};
  if (triangles.size() > gpu::kPageMaxTriangles)
    return Error{ErrorCode::kUnsupported,
                 "a zone has " + std::to_string(triangles.size()) + " triangles, more than a page can number"};
  if (options.method == BvhMethod::kAuto) return build_cheapest(triangles, options);
  const BvhMethod plain = without_reinsertion(options.method);
  BinaryTree binary = build_binary(triangles, plain, options);
  if (plain != options.method) optimize_by_reinsertion(binary, options.reinsertion);
  return collapse_within_depth(binary, options.collapse);
}

}  // namespace zc
