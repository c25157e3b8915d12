// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/simplify.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "baker/proxy/cluster.h"
#include "baker/proxy/components.h"
#include "baker/proxy/decimate.h"
#include "baker/proxy/patches.h"
#include "baker/proxy/vertex_collapse.h"

namespace zc {
namespace {

constexpr double kLeafNormalTurnDeg = 2;
constexpr double kLeastTolerance = 0.5;  // steps
constexpr double kInnerNormalTurnDeg = 75;
constexpr double kDecimationStuck = 0.8;  // of what it was given
constexpr double kInnerTarget = 0.35;     // of the children's triangles
constexpr double kInnerTargetSmall = 0.65;
constexpr double kEnough = 0.5;           // of the tolerance: how far something lost may be from all that is left
constexpr std::size_t kStandInShare = 4;  // of the target goes to what stands in for the lost, at most
constexpr double kFirstToleranceM = 0.25;
constexpr double kSmallParts = 2;  // of the tolerance: smaller parts go before larger ones lose their shapes

std::vector<bool> locked_vertices(const CellGrid& grid, const Zone& zone, const LatticeMesh& mesh) {
  std::vector<bool> locked(mesh.vertices.size());
  for (std::size_t i = 0; i < locked.size(); ++i) locked[i] = grid.on_cell_border(zone, mesh.vertices[i]);
  return locked;
}

LatticeMesh part_of(const LatticeMesh& mesh, bool ground) {
  LatticeMesh part;
  part.vertices = mesh.vertices;
  std::ranges::copy_if(mesh.faces, std::back_inserter(part.faces),
                       [&](const LatticeFace& face) { return face.ground == ground; });
  weld(part);
  return part;
}

// A cell whose vertices may join within the tolerance.
std::uint32_t cluster_cell(double tolerance) {
  return static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(std::max(tolerance / 2, 1.0)))) - 1;
}

// Doubles the tolerance until the mesh is small enough, or the tolerance senseless for the cell. Returns the last.
double coarsen(const SimplifyContext& context, const Zone& zone, double tolerance, std::size_t target,
               LatticeMesh& mesh) {
  const double limit = bounds_of(mesh).diagonal() / 8;
  for (; mesh.faces.size() > target; tolerance *= 2) {
    drop_small_components(mesh, kSmallParts * tolerance, target);
    if (mesh.faces.size() <= target) return tolerance;
    absorb_small_patches(mesh, 2 * tolerance);
    const auto before = static_cast<double>(mesh.faces.size());
    mesh = decimate(mesh, locked_vertices(*context.grid, zone, mesh),
                    {tolerance, target, kInnerNormalTurnDeg, /*keep_material_borders=*/true});
    if (mesh.faces.size() > target && static_cast<double>(mesh.faces.size()) > kDecimationStuck * before) {
      // Soup of many loose patches has no edges to collapse.
      LatticeMesh clustered =
          cluster_vertices(mesh, locked_vertices(*context.grid, zone, mesh), cluster_cell(tolerance));
      // Far below the target is worse than somewhat above it.
      if (clustered.faces.size() >= target / 2 && !clustered.faces.empty()) mesh = std::move(clustered);
    }
    if (tolerance > limit || mesh.faces.size() <= target) return tolerance;
  }
  return tolerance;
}

// Whatever it takes: vertices cluster on ever coarser grids; where that would leave nothing, the smallest parts go.
void force_below(std::size_t target, LatticeMesh& mesh) {
  for (std::uint32_t cell_log2 = 1; mesh.faces.size() > target && cell_log2 < 30; ++cell_log2) {
    LatticeMesh clustered = cluster_vertices(mesh, std::vector<bool>(mesh.vertices.size()), cell_log2);
    if (clustered.faces.empty()) break;
    mesh = std::move(clustered);
  }
  if (mesh.faces.size() > target) drop_components_to(mesh, target);
  if (mesh.faces.size() > target) {
    mesh.faces.resize(target);
    weld(mesh);
  }
}

void add_work(Proxy& proxy) {
  proxy.work += proxy.error.work;
  proxy.is_bounded = proxy.is_bounded || proxy.error.is_loose;
}

}  // namespace

double rounding_m(double step_m, std::uint32_t step_shift) {
  return step_shift == 0 ? 0 : std::ldexp(std::sqrt(0.75) * step_m, static_cast<int>(step_shift));
}

Proxy round_detail(const LatticeMesh& detail) {
  Proxy out;
  out.mesh = detail;
  out.step_shift = step_shift_for_box(bounds_of(detail));
  round_to_step(out.mesh, out.step_shift);
  return out;
}

Proxy simplify_leaf(const SimplifyContext& context, const Zone& zone, const Proxy& rounded,
                    const DetailSurface& detail) {
  // What rounding moved is not there to be moved again.
  const double rest = (context.error_m - rounding_m(context.step_m, rounded.step_shift)) / context.step_m;
  const double tolerance = rest - zone.most_moved();
  Proxy out = rounded;
  // What collapses keeps the bound, as long as nothing was lost before.
  bool keeps_bound = tolerance >= kLeastTolerance && rounded.mesh.faces.size() == zone.detail.faces.size();
  if (tolerance >= kLeastTolerance) {
    LatticeMesh mesh;
    for (const bool ground : {true, false}) {
      LatticeMesh part = part_of(rounded.mesh, ground);
      const Collapsed collapsed =
          collapse_vertices(part, locked_vertices(*context.grid, zone, part), context.appearances,
                            {rest - zone.moved[ground ? 1 : 0], kLeafNormalTurnDeg, 0});
      append(mesh, collapsed.mesh);
      out.work += collapsed.work.done;
      out.is_bounded = out.is_bounded || collapsed.work.is_spent();
    }
    weld(mesh);
    out.mesh = std::move(mesh);
  }
  if (zone.parent < 0 && out.mesh.faces.size() > context.leaf_triangles) {
    // A world of one zone: its proxy is the pinned root as well.
    coarsen(context, zone, kFirstToleranceM / context.step_m, context.leaf_triangles, out.mesh);
    force_below(context.leaf_triangles, out.mesh);
    out.step_shift = step_shift_for_box(bounds_of(out.mesh));
    round_to_step(out.mesh, out.step_shift);
    keeps_bound = false;
  }
  out.error = measure_proxy(out.mesh, std::span(&detail, 1), context.materials, context.appearances, context.step_m,
                            context.error_m);
  add_work(out);
  if (keeps_bound) out.error.max_m = std::min(out.error.max_m, context.error_m);
  return out;
}

std::optional<Proxy> simplify_inner(const SimplifyContext& context, const Zone& zone,
                                    std::span<const Proxy* const> children, std::span<const DetailSurface> detail) {
  const bool is_root = zone.parent < 0;
  std::size_t sum = 0;
  double child_error_m = 0;
  double child_appearance_m = 0;
  // Not from the children's errors: one lost shed far from everything would make all that is coarser shapeless.
  double tolerance = kFirstToleranceM / context.step_m;
  Proxy out;
  for (const Proxy* child : children) {
    sum += child->mesh.faces.size();
    child_error_m = std::max(child_error_m, child->error.max_m);
    child_appearance_m = std::max(child_appearance_m, child->error.appearance_m);
    tolerance = std::max(tolerance, child->tolerance);
    append(out.mesh, child->mesh);
  }
  // A node far below the size of a zone is not worth being coarser still: it need only save enough to be stored.
  const double small = std::min(context.leaf_triangles / 4.0, kInnerTargetSmall * static_cast<double>(sum));
  const double share = std::max(kInnerTarget * static_cast<double>(sum), small);
  // The root is only ever a stand-in, but always resident: it decides the smallest cap that works.
  const std::size_t limit = is_root ? std::max(1U, context.leaf_triangles / 4) : context.leaf_triangles;
  const std::size_t target = std::max<std::size_t>(1, std::min(limit, static_cast<std::size_t>(share)));
  out.step_shift = step_shift_for_box(bounds_of(out.mesh));
  round_to_step(out.mesh, out.step_shift);
  const LatticeMesh before = out.mesh;
  out.tolerance = coarsen(context, zone, tolerance, target, out.mesh);
  if (is_root) force_below(context.leaf_triangles, out.mesh);
  const auto spare = [&](double bound) {
    return static_cast<std::size_t>(std::max(0.0, bound - static_cast<double>(out.mesh.faces.size())));
  };
  if (!out.mesh.faces.empty())
    add_stand_ins(before, kEnough * out.tolerance,
                  std::min(target / kStandInShare,
                           is_root ? spare(context.leaf_triangles) : spare(kStoredAtMost * static_cast<double>(sum))),
                  out.mesh);
  if (out.mesh.faces.empty()) {
    if (!is_root) return std::nullopt;
    // Rounding left nothing: the root is what it was before it.
    const Proxy* largest = *std::max_element(children.begin(), children.end(), [](const Proxy* a, const Proxy* b) {
      return bounds_of(a->mesh).diagonal() < bounds_of(b->mesh).diagonal();
    });
    out.mesh = largest->mesh;
    force_below(context.leaf_triangles, out.mesh);
  }
  if (!is_root && static_cast<double>(out.mesh.faces.size()) > kStoredAtMost * static_cast<double>(sum))
    return std::nullopt;
  out.step_shift = step_shift_for_box(bounds_of(out.mesh));
  round_to_step(out.mesh, out.step_shift);
  if (out.mesh.faces.empty()) return std::nullopt;
  out.error = measure_proxy(out.mesh, detail, context.materials, context.appearances, context.step_m);
  add_work(out);
  // Refinement must never raise the promised error.
  out.error.max_m = std::max(out.error.max_m, child_error_m);
  out.error.appearance_m = std::max(out.error.appearance_m, child_appearance_m);
  return out;
}

}  // namespace zc
