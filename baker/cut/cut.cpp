// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/cut/cut.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "baker/cut/clip.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr std::int64_t kMinCellM = 16;
constexpr std::int64_t kWholeObjectMaxM = 128;

// Pieces, for each that there is now, that a cut may make at most: where more triangles lie over each other than beside
// each other, smaller cells contain hardly fewer.
constexpr std::uint64_t kPiecesMax = 2;
// And all cuts above together: a zone of more pieces than this for each whole triangle's worth in it has long triangles
// side by side, which smaller cells only make more of.
constexpr double kPiecesPerTriangle = 64;

// For fine steps alone the world is cut into no more cells than 128 along a side; into 32 where that cuts a handful of
// wide triangles into any number of pieces.
constexpr std::uint32_t kWidthDepthLimit = 7;
constexpr std::uint32_t kFewWidthDepthLimit = 5;
constexpr std::uint64_t kFewTriangles = 64;

struct WholeObject {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  LatticeBox box;

  [[nodiscard]] std::int64_t center(std::size_t axis) const {
    return (std::int64_t{box.min[axis]} + box.max[axis]) / 2;
  }
};

struct Subtree {
  Zone zone;
  std::vector<LooseFace> cut;
  std::vector<WholeObject> whole;
  std::vector<std::unique_ptr<Subtree>> children;
  std::vector<EdgeSplit> splits;
};

std::uint64_t triangles_in(const Subtree& tree) {
  std::uint64_t count = tree.cut.size();
  for (const auto& object : tree.whole) count += object.count;
  return count;
}

// Whether cutting has only made more triangles of the same ones so far.
bool is_chopped(const Subtree& tree) {
  double triangles = 0;
  for (const LooseFace& face : tree.cut) triangles += static_cast<double>(face.share);
  for (const auto& object : tree.whole) triangles += object.count;
  return static_cast<double>(triangles_in(tree)) > kPiecesPerTriangle * triangles;
}

// At most so many triangles a cut in the middle leaves in all quarters together, clipped polygons counted as one.
std::uint64_t pieces_in_quarters(const Subtree& tree, const std::array<std::int64_t, 2>& middle) {
  std::uint64_t count = triangles_in(tree) - tree.cut.size();
  for (const LooseFace& face : tree.cut) {
    LatticeBox box;
    for (const LatticePoint& p : face.p) box.add(p);
    std::uint64_t quarters = 1;
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (box.min[axis] < middle[axis] && box.max[axis] > middle[axis]) quarters *= 2;
    count += quarters;
  }
  return count;
}

LatticeBox box_of(const Subtree& tree) {
  LatticeBox box;
  for (const LooseFace& face : tree.cut)
    for (const LatticePoint& p : face.p) box.add(p);
  for (const WholeObject& object : tree.whole) box.add(object.box);
  return box;
}

struct LeafLimits {
  std::uint32_t triangles = 0;
  std::uint32_t step_shift = 0;
};

void split(Subtree& tree, const CellGrid& grid, const LeafLimits& limits) {
  // One object that stays whole gains nothing from smaller cells.
  const bool divisible = !tree.cut.empty() || tree.whole.size() > 1;
  const std::uint64_t triangles = triangles_in(tree);
  const bool is_wide = tree.zone.depth < kWidthDepthLimit && step_shift_for_box(box_of(tree)) > limits.step_shift;
  if (!divisible || (triangles <= limits.triangles && !is_wide) || !grid.can_split(tree.zone.depth)) return;
  const std::int64_t half = grid.cell_size(tree.zone.depth) / 2;
  const std::array<std::int64_t, 2> middle = {(2 * std::int64_t{tree.zone.cell_x} + 1) * half,
                                              (2 * std::int64_t{tree.zone.cell_y} + 1) * half};
  const bool is_few = is_wide && triangles <= kFewTriangles && tree.zone.depth < kFewWidthDepthLimit;
  if (!is_few && pieces_in_quarters(tree, middle) > kPiecesMax * triangles) return;
  if (!is_wide && is_chopped(tree)) return;
  std::array<std::unique_ptr<Subtree>, 4> parts;
  for (std::uint32_t i = 0; i < 4; ++i) {
    parts[i] = std::make_unique<Subtree>();
    parts[i]->zone.depth = tree.zone.depth + 1;
    parts[i]->zone.cell_x = 2 * tree.zone.cell_x + (i & 1U);
    parts[i]->zone.cell_y = 2 * tree.zone.cell_y + (i >> 1U);
  }
  auto columns = clip_faces(tree.cut, 0, static_cast<std::int32_t>(middle[0]), grid, tree.splits);
  tree.cut = std::vector<LooseFace>();  // `= {}` would keep its memory
  for (std::size_t x = 0; x < 2; ++x) {
    auto& column = x == 0 ? columns.low : columns.high;
    auto rows = clip_faces(column, 1, static_cast<std::int32_t>(middle[1]), grid, tree.splits);
    column = std::vector<LooseFace>();
    parts[x]->cut = std::move(rows.low);
    parts[x + 2]->cut = std::move(rows.high);
  }
  for (const auto& object : tree.whole) {
    const std::size_t x = object.center(0) >= middle[0] ? 1 : 0;
    const std::size_t y = object.center(1) >= middle[1] ? 2 : 0;
    parts[x + y]->whole.push_back(object);
  }
  tree.whole = std::vector<WholeObject>();
  for (auto& part : parts)
    if (triangles_in(*part) > 0) tree.children.push_back(std::move(part));
  tbb::parallel_for(std::size_t{0}, tree.children.size(),
                    [&](std::size_t i) { split(*tree.children[i], grid, limits); });
}

void collect_splits(Subtree& tree, std::vector<EdgeSplit>& out) {
  out.insert(out.end(), tree.splits.begin(), tree.splits.end());
  tree.splits = std::vector<EdgeSplit>();
  for (auto& child : tree.children) collect_splits(*child, out);
}

void make_detail(Subtree& leaf, const LatticeMesh& source, const std::vector<EdgeSplit>& splits) {
  apply_splits(leaf.cut, splits);
  LatticeMesh& mesh = leaf.zone.detail;
  for (const auto& face : leaf.cut) {
    float& moved = leaf.zone.moved[face.ground ? 1 : 0];
    moved = std::max({moved, face.moved[0], face.moved[1], face.moved[2]});
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), face.p.begin(), face.p.end());
    mesh.faces.push_back({{base, base + 1, base + 2}, face.material, face.ground});
  }
  for (const auto& object : leaf.whole) {
    for (std::uint32_t i = object.first; i < object.first + object.count; ++i) {
      LatticeFace face = source.faces[i];
      for (std::uint32_t& v : face.v) {
        mesh.vertices.push_back(source.vertices[v]);
        v = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
      }
      mesh.faces.push_back(face);
    }
  }
  leaf.cut = std::vector<LooseFace>();
  clean(mesh);
}

LatticeBox box_of(const SceneObject& object, const LatticeMesh& mesh) {
  LatticeBox box;
  for (std::uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i)
    for (const std::uint32_t v : mesh.faces[i].v) box.add(mesh.vertices[v]);
  return box;
}

std::int64_t longest_side(const LatticeBox& box) {
  std::int64_t side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, std::int64_t{box.max[axis]} - box.min[axis]);
  return side;
}

enum class Shape { kWhole, kGround, kWide, kDense };

// Whether an object stays whole, and if not, why.
Shape shape_of(const SceneObject& object, const LatticeBox& box, std::int32_t step_log2, std::uint32_t leaf_triangles) {
  if (object.kind == ObjectKind::kGround) return Shape::kGround;
  if (longest_side(box) > kWholeObjectMaxM << -step_log2) return Shape::kWide;
  return object.triangle_count > kDetailZonesLimit * leaf_triangles ? Shape::kDense : Shape::kWhole;
}

// Sorts the scene's objects into those that stay whole and loose faces.
Subtree make_root(const CutInput& input, std::vector<ImportCount>& notes) {
  const LatticeMesh& mesh = input.scene.mesh;
  std::uint64_t wide = 0;
  std::uint64_t dense = 0;
  Subtree root;
  for (const auto& object : input.scene.objects) {
    const LatticeBox box = box_of(object, mesh);
    const Shape shape = shape_of(object, box, input.scene.lattice.step_log2, input.leaf_triangles);
    if (shape == Shape::kWhole) {
      root.whole.push_back({object.first_triangle, object.triangle_count, box});
      continue;
    }
    wide += shape == Shape::kWide ? 1 : 0;
    dense += shape == Shape::kDense ? 1 : 0;
    for (std::uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
      const LatticeFace& face = mesh.faces[i];
      const auto& p = mesh.vertices;
      root.cut.push_back({{p[face.v[0]], p[face.v[1]], p[face.v[2]]}, {}, 1, face.material, face.ground});
    }
  }
  if (wide > 0) notes.push_back({"objects wider than 128 m, cut at zone borders", wide});
  if (dense > 0) notes.push_back({"objects of more triangles than four zones, cut at zone borders", dense});
  return root;
}

}  // namespace

std::uint32_t CellGrid::step_shift_bound(std::uint32_t depth) const {
  return step_shift_for_extent(std::max(cell_size(depth) + overhang, height));
}

bool CellGrid::may_be_border(std::int32_t coordinate) const {
  return coordinate > 0 && coordinate < (std::int64_t{1} << root_log2) &&
         static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint32_t>(coordinate))) >= min_cell_log2;
}

std::uint32_t CellGrid::border_shift(std::int32_t coordinate) const {
  if (!may_be_border(coordinate)) return 0;
  // A plane at an odd multiple of a cell's size first separates cells of that size.
  const auto zeros = static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint32_t>(coordinate)));
  return step_shift_bound(root_log2 - zeros);
}

bool CellGrid::can_split(std::uint32_t depth) const { return root_log2 - depth > min_cell_log2; }

bool CellGrid::on_cell_border(const Zone& zone, const LatticePoint& p) const {
  const std::int64_t size = cell_size(zone.depth);
  const std::int64_t end = std::int64_t{1} << root_log2;
  return std::ranges::any_of(std::array{p[0], p[1]}, [&](std::int64_t c) { return c > 0 && c < end && c % size == 0; });
}

CellGrid fit_cells(const SnappedScene& scene, std::uint32_t leaf_triangles) {
  const std::int32_t step_log2 = scene.lattice.step_log2;
  std::int64_t whole_size = 0;
  for (const SceneObject& object : scene.objects) {
    const LatticeBox box = box_of(object, scene.mesh);
    if (shape_of(object, box, step_log2, leaf_triangles) == Shape::kWhole)
      whole_size = std::max(whole_size, longest_side(box));
  }
  const LatticeBox box = bounds_of(scene.mesh);
  const std::int64_t extent = std::max<std::int64_t>({box.max[0], box.max[1], 1}) + 1;
  CellGrid grid;
  grid.min_cell_log2 = static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint64_t>(kMinCellM))) +
                       static_cast<std::uint32_t>(-step_log2);
  grid.root_log2 =
      std::max(grid.min_cell_log2, static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(extent - 1))));
  // Half of it on either side of where its centre may be. A power of two: another object hardly ever changes the grid.
  grid.overhang = static_cast<std::int64_t>(std::bit_ceil(static_cast<std::uint64_t>(whole_size) + 1));
  grid.height = std::int64_t{box.max[2]} - std::min(box.min[2], 0);
  // Border planes are multiples of every step that is used on them.
  grid.min_cell_log2 = std::max(grid.min_cell_log2, grid.step_shift_bound(0));
  grid.root_log2 = std::max(grid.root_log2, grid.min_cell_log2);
  return grid;
}

std::uint32_t leaf_step_shift(double error_m, double step_m) {
  std::uint32_t shift = 0;
  while (std::ldexp(std::sqrt(0.75) * step_m, static_cast<int>(shift) + 1) <= error_m * 2 / 3) ++shift;
  return shift;
}

Result<CutScene> cut_zones(CutInput&& input, BakeContext& context) {
  context.begin(BakeStage::kCut);
  SnappedScene& scene = input.scene;
  CutScene out;
  out.notes = std::move(scene.notes);
  Subtree root = make_root(input, out.notes);
  split(root, input.grid, {input.leaf_triangles, input.leaf_shift});
  std::vector<EdgeSplit> splits;
  collect_splits(root, splits);
  std::sort(splits.begin(), splits.end());
  splits.erase(std::unique(splits.begin(), splits.end()), splits.end());

  std::vector<Subtree*> order = {&root};
  root.zone.parent = -1;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (auto& child : order[i]->children) {
      child->zone.parent = static_cast<std::int32_t>(i);
      order[i]->zone.children.push_back(static_cast<std::uint32_t>(order.size()));
      order.push_back(child.get());
    }
  }
  std::vector<Zone>& zones = out.tree.zones;
  zones.resize(order.size());
  tbb::parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
    if (order[i]->children.empty()) make_detail(*order[i], scene.mesh, splits);
    zones[i] = std::move(order[i]->zone);
  });
  out.tree.grid = input.grid;
  out.lattice = scene.lattice;
  out.materials = std::move(scene.materials);
  out.crs = std::move(scene.crs);
  scene = {};
  return out;
}

}  // namespace zc
