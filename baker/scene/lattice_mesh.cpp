// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/scene/lattice_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/check.h"

namespace zc {
namespace {

using Cross = std::array<std::int64_t, 3>;

Cross cross_of(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  Cross u;
  Cross v;
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = std::int64_t{b[i]} - a[i];
    v[i] = std::int64_t{c[i]} - a[i];
  }
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

}  // namespace

double WorldLattice::step_m() const { return std::ldexp(1.0, step_log2); }

void LatticeBox::add(const LatticePoint& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    min[i] = std::min(min[i], p[i]);
    max[i] = std::max(max[i], p[i]);
  }
}

void LatticeBox::add(const LatticeBox& box) {
  if (box.empty()) return;
  add(box.min);
  add(box.max);
}

double LatticeBox::diagonal() const {
  if (empty()) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double side = static_cast<double>(max[i]) - static_cast<double>(min[i]);
    sum += side * side;
  }
  return std::sqrt(sum);
}

LatticeBox bounds_of(const LatticeMesh& mesh) {
  LatticeBox box;
  for (const auto& face : mesh.faces)
    for (const std::uint32_t v : face.v) box.add(mesh.vertices[v]);
  return box;
}

bool is_degenerate(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return cross_of(a, b, c) == Cross{0, 0, 0};
}

double face_area(const LatticeMesh& mesh, const LatticeFace& face) {
  const Cross n = cross_of(mesh.vertices[face.v[0]], mesh.vertices[face.v[1]], mesh.vertices[face.v[2]]);
  const auto x = static_cast<double>(n[0]);
  const auto y = static_cast<double>(n[1]);
  const auto z = static_cast<double>(n[2]);
  return 0.5 * std::sqrt(x * x + y * y + z * z);
}

std::array<std::uint32_t, 3> rotated(const std::array<std::uint32_t, 3>& v) {
  if (v[0] <= v[1] && v[0] <= v[2]) return v;
  if (v[1] <= v[0] && v[1] <= v[2]) return {v[1], v[2], v[0]};
  return {v[2], v[0], v[1]};
}

void weld(LatticeMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& face : mesh.faces)
    for (const std::uint32_t v : face.v) used[v] = true;
  std::vector<std::uint32_t> order;
  order.reserve(mesh.vertices.size());
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i)
    if (used[i]) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return mesh.vertices[a] < mesh.vertices[b]; });
  std::vector<std::uint32_t> target(mesh.vertices.size(), 0);
  std::vector<LatticePoint> points;
  for (const std::uint32_t i : order) {
    if (points.empty() || points.back() != mesh.vertices[i]) points.push_back(mesh.vertices[i]);
    target[i] = static_cast<std::uint32_t>(points.size() - 1);
  }
  for (auto& face : mesh.faces)
    for (std::uint32_t& v : face.v) v = target[v];
  mesh.vertices = std::move(points);
}

void clean(LatticeMesh& mesh) {
  weld(mesh);
  std::erase_if(mesh.faces, [&](const LatticeFace& f) {
    return is_degenerate(mesh.vertices[f.v[0]], mesh.vertices[f.v[1]], mesh.vertices[f.v[2]]);
  });
  std::vector<std::pair<std::array<std::uint32_t, 3>, std::uint32_t>> keys;
  keys.reserve(mesh.faces.size());
  for (std::uint32_t i = 0; i < mesh.faces.size(); ++i) keys.emplace_back(rotated(mesh.faces[i].v), i);
  std::sort(keys.begin(), keys.end());
  std::vector<bool> drop(mesh.faces.size(), false);
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) drop[keys[i].second] = true;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    if (!drop[i]) mesh.faces[kept++] = mesh.faces[i];
  mesh.faces.resize(kept);
  weld(mesh);
}

void append(LatticeMesh& mesh, const LatticeMesh& other) {
  ZC_CHECK(mesh.vertices.size() + other.vertices.size() <= UINT32_MAX);
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (LatticeFace face : other.faces) {
    for (std::uint32_t& v : face.v) v += base;
    mesh.faces.push_back(face);
  }
}

std::uint32_t step_shift_for_extent(std::int64_t extent) {
  // Aligning may add one step at either end.
  std::uint32_t shift = 0;
  while ((extent >> shift) + 2 > 65535) ++shift;
  return shift;
}

std::uint32_t step_shift_for_box(const LatticeBox& box) {
  std::int64_t extent = 0;
  for (std::size_t i = 0; i < 3; ++i) extent = std::max(extent, std::int64_t{box.max[i]} - box.min[i]);
  return step_shift_for_extent(extent);
}

std::int32_t round_to_step(std::int64_t value, std::uint32_t shift) {
  if (shift == 0) return static_cast<std::int32_t>(value);
  const std::int64_t half = std::int64_t{1} << (shift - 1);
  return static_cast<std::int32_t>(((value + half) >> shift) << shift);
}

void round_to_step(LatticeMesh& mesh, std::uint32_t shift) {
  for (auto& p : mesh.vertices)
    for (std::int32_t& c : p) c = round_to_step(c, shift);
  clean(mesh);
}

}  // namespace zc
