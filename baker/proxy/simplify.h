// SPDX-License-Identifier: GPL-3.0-or-later
// Proxies of zones: a leaf's under an error bound, an inner node's towards a triangle count.
// Borrows the zones and the grid. Thread-safe: no state. Deterministic at any thread count.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "baker/cut/cut.h"
#include "baker/distance/measure.h"

namespace zc {

struct Proxy {
  LatticeMesh mesh;  // vertices are multiples of 2^step_shift
  std::uint32_t step_shift = 0;
  SurfaceError error;
  double tolerance = 0;     // steps; what the simplification was allowed at the end
  std::uint64_t work = 0;   // boxes and triangles visited for it; none where it comes from a cache
  bool is_bounded = false;  // it took all the work that it may: with more, triangles or stored distances would be fewer
};

struct SimplifyContext {
  const CellGrid* grid = nullptr;
  std::span<const Material> materials;
  std::span<const std::uint16_t> appearances;  // appearance_classes(materials)
  double step_m = 0;
  double error_m = 0;                // bound of leaf proxies
  std::uint32_t leaf_triangles = 0;  // hard bound of the root, target elsewhere
  bool atlases = false;              // textured zones have one
};

// How far rounding to a step moves a point at most.
double rounding_m(double step_m, std::uint32_t step_shift);

// The detail itself on its own step; empty when no triangle survives the rounding.
Proxy round_detail(const LatticeMesh& detail);

// `rounded`: round_detail of the zone's detail, the result where nothing simpler keeps the bound.
Proxy simplify_leaf(const SimplifyContext& context, const Zone& zone, const Proxy& rounded,
                    const DetailSurface& detail);

// Of the triangles of the proxies below: with more a proxy is not stored.
inline constexpr double kStoredAtMost = 0.70;

// From the proxies below. None where it would save too little; the root always gets one, of at most
// leaf_triangles triangles.
std::optional<Proxy> simplify_inner(const SimplifyContext& context, const Zone& zone,
                                    std::span<const Proxy* const> children, std::span<const DetailSurface> detail);

}  // namespace zc
